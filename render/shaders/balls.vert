layout(location = 0) in vec3 position;
layout(location = 2) in vec4 colour;
layout(location = 4) in float radius;

layout(location = 0) uniform float smallest;  // pixels
layout(location = 1) uniform int in_shadow_map;

flat out vec3 ball_colour;
flat out vec4 ball;  // radius over depth, depth, two of the projection's numbers
#ifdef BEYOND
flat out vec3 near_at;  // as in shadow.vert
#endif

void main()
{
    vec3 p = (position - units.xyz) * units.w;
    float r = radius * units.w;
    ball_colour = colour.rgb;
    if (in_shadow_map == 1) {
#ifdef BEYOND
        near_at = (shadow_from_stage * vec4(p, 1.0)).xyz;
        gl_Position = vec4((far_from_stage * vec4(p, 1.0)).xyz, 1.0);
        float texel = far_size.z;
#else
        gl_Position = vec4((shadow_from_stage * vec4(p, 1.0)).xyz, 1.0);
        float texel = light.w;
#endif
        gl_Position.xy = gl_Position.xy * 2.0 - 1.0;
        gl_PointSize = max(2.0 * r / texel, 1.0);
        ball = vec4(0.0);
    } else {
        gl_Position = clip_from_stage * vec4(p, 1.0);
        float depth = max(gl_Position.w, 1e-6);
        float pixel = length(down.xyz) / floor_colour.w;  // at depth 1
        gl_PointSize = max(2.0 * r / (depth * pixel), smallest * floor_colour.w);
        ball = vec4(0.5 * gl_PointSize * pixel * depth, depth, 0.0, 0.0);
    }
}
