// The marked pixels again, each of their samples with its own light.
layout(location = 0) out vec4 colour;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < 4; ++k) {
        ivec2 from = 2 * at + ivec2(k & 1, k >> 1);
        vec3 ray = ray_at(vec2(at) + vec2(k & 1, k >> 1) * 0.5 + 0.25);
        float stored = texelFetch(depths, from, 0).x;
        float t = floor_depth(ray);
        bool on_floor = sky.w > 0.0 && eye.y > bounce.w && ray.y < 0.0 &&
                        (stored <= 0.0 || t < view_depth(stored));
        vec3 n = vec3(0.0, 1.0, 0.0);
        vec3 light_here = backdrop(ray);
        if (on_floor) {
            light_here = floor_light(ray, t, lit_share(eye.xyz + t * ray, n));
        } else if (stored > 0.0) {
            light_here = stored_light(texelFetch(pixels, from, 0).xy, stored, ray);
        }
        sum += tone_map(light_here);
    }
    colour = shown(0.25 * sum);
}
