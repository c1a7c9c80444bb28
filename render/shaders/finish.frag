// After transparent things: light to colours for the eye, and several samples to one pixel.
layout(binding = 0) uniform sampler2D light_in;

layout(location = 0) out vec4 colour;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    int samples = int(floor_colour.w);
    vec3 sum = vec3(0.0);
    for (int j = 0; j < samples; ++j) {
        for (int i = 0; i < samples; ++i) {
            sum += tone_map(texelFetch(light_in, samples * at + ivec2(i, j), 0).rgb);
        }
    }
    colour = shown(sum / float(samples * samples));
}
