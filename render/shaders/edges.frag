// The marked pixels again, each of their samples with its own light.
layout(location = 0) out vec4 colour;

layout(binding = 7) uniform usampler2DArray fine_pixels;
layout(binding = 8) uniform sampler2DArray fine_depths;

// As in renderer.cpp.
const vec2 PLACES[4] = vec2[](vec2(-0.125, -0.375), vec2(0.375, -0.125), vec2(-0.375, 0.125), vec2(0.125, 0.375));

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 sum = vec3(0.0);
    float cover = 0.0;
    for (int k = 0; k < 4; ++k) {
        vec2 place = vec2(at) + 0.5 + PLACES[k];
        vec3 ray = ray_at(place);
        float stored = texelFetch(fine_depths, ivec3(at, k), 0).x;
        float t = floor_depth(ray), lowered = t - FLOOR_LOWERED / ray.y;
        bool on_floor = sky.w > 0.0 && eye.y > bounce.w && ray.y < 0.0 &&
                        (stored <= 0.0 || lowered < view_depth(stored));
        float depth = on_floor ? t : view_depth(stored);
        uvec2 pixel = texelFetch(fine_pixels, ivec3(at, k), 0).xy;
        vec3 n = on_floor ? vec3(0.0, 1.0, 0.0) : stored_normal(pixel);
        // Once for both: this OpenGL goes both ways of a branch.
        vec2 reach = light_reaching(place, depth, eye.xyz + depth * ray, n);
        vec3 light_here = linear_out == 2 ? vec3(0.0) : backdrop(ray);
        float covered = 0.0;
        if (on_floor) {
            light_here = floor_light(ray, t, reach, covered);
        } else if (stored > 0.0) {
            light_here = stored_light(pixel, n, ray, reach);
            covered = 1.0;
        }
        sum += linear_out == 0 ? tone_map(light_here) : light_here;
        cover += covered;
    }
    colour = linear_out == 0 ? shown(0.25 * sum) : finished(0.25 * sum, 0.25 * cover);
}
