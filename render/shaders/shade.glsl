// How light meets things. Directional key light with a shadow, sky and bounce from a hemisphere,
// GGX highlights.
//   Walter et al., Microfacet models for refraction through rough surfaces, EGSR 2007 (D);
//   Heitz, Understanding the masking-shadowing function, JCGT 3(2), 2014, with Hammon's
//   approximation of the height-correlated term, GDC 2017 (V); Schlick 1994 (F);
//   Lazarov, Getting more physical in Call of Duty: Black Ops II, SIGGRAPH courses 2013, as fitted
//   by Karis 2014 (how much of the surroundings a rough surface reflects);
//   Jimenez et al., Practical real-time strategies for accurate indirect occlusion, SIGGRAPH
//   courses 2016 (light that bounces about in a corner keeps the corner's colour).
// STYLE is a Style of look.hpp; GRID, GLASS and FAR are 1 where the floor has lines, where clear things
// are glass, and where there is a far shadow map. This OpenGL goes both ways of an if, also where all pixels would go the same one.
layout(binding = 2) uniform sampler2DShadow shadow_map;

struct Material {
    vec3 colour;  // linear
    float rough, metal;
};

// From where a ray towards the light leaves stage point p, for a map of such texels: those that the
// surface crosses obliquely are deep.
vec3 off_surface(vec3 p, vec3 n, float texel)
{
    float slope = 1.0 - max(dot(n, to_light.xyz), 0.0);
    return p + n * texel * (1.0 + 3.0 * slope) + to_light.xyz * texel;
}

// What of the key light reaches the point `at` of a map with `size` texels: a tent, READS x 2 texels
// wide. 0 unless `wanted`.
float tent(sampler2DShadow map, vec2 size, vec3 at, bool wanted)
{
    float ahead = clamp(at.z, 0.0, 1.0);
    vec2 texels = at.xy * size - 0.5;
    vec2 first = floor(texels), part = texels - first;
    vec2 texel_size = 1.0 / size;
    const float reach = float(READS);
    float sum = 0.0;
    int rows = wanted ? READS : 0;
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < READS; ++i) {
            vec2 step_to = vec2(2 * i, 2 * j) - (reach - 2.0);
            vec4 g = textureGather(map, (first + step_to) * texel_size, ahead);
            vec2 low = reach - abs(step_to - 1.0 - part), high = reach - abs(step_to - part);
            sum += low.y * (low.x * g.w + high.x * g.z) + high.y * (low.x * g.x + high.x * g.y);
        }
    }
    return sum / (reach * reach * reach * reach);
}

bool on_map(vec2 at) { return all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(1.0))); }

#if FAR == 1
layout(binding = 11) uniform sampler2DShadow far_map;

// The share of the key light that what lies beyond the near shadow map lets through to stage point p.
float far_share(vec3 p, vec3 n)
{
    // As far as a penumbra reaches, and soften.frag.
    float filtered = min(0.06 + 16.0 * length(p - eye.xyz) * length(down.xyz), BOTH);
    bool near_tells = inside_near((shadow_from_stage * vec4(p, 1.0)).xyz) > filtered;
    vec3 at = (far_from_stage * vec4(off_surface(p, n, far_size.z), 1.0)).xyz;
    bool wanted = !near_tells && on_map(at.xy);
    float lit = tent(far_map, far_size.xy, at, wanted);
    return wanted ? lit : 1.0;
}
#endif

// The share of the key light that reaches stage point p.
float lit_share(vec3 p, vec3 n)
{
    if (to_light.w == 0.0) return 1.0;
    vec3 at = (shadow_from_stage * vec4(off_surface(p, n, light.w), 1.0)).xyz;
    float lit = tent(shadow_map, shadow_size.xy, at, true);
#if FAR == 1
    lit = (on_map(at.xy) ? lit : 1.0) * far_share(p, n);
#endif
    return lit;
}

vec3 hemisphere(float up) { return mix(bounce.rgb, sky.rgb, 0.5 + 0.5 * up); }

// The share of the light from all around that a corner of this colour sends on.
vec3 in_corner(vec3 colour, float open)
{
    vec3 a = 2.0404 * colour - 0.3324, b = -4.7951 * colour + 0.6417, c = 2.7552 * colour + 0.6903;
    return max(vec3(open), ((open * a + b) * open + c) * open);
}

#if STYLE == DIAGRAM
// Two flat tones, paler than the material.
vec3 shade(Material m, vec3 n, vec3 v, vec2 reach)
{
    float lit = smoothstep(-0.02, 0.02, dot(n, to_light.xyz)) * step(0.5, reach.x);
    return mix(m.colour, vec3(0.8), 0.18) * mix(0.72, 1.0, lit);
}
#elif STYLE == MATCAP
// A ball lit from the upper left, dark at its rim, as the camera sees it.
vec3 shade(Material m, vec3 n, vec3 v, vec2 reach)
{
    vec3 right = normalize(across.xyz), up = -normalize(down.xyz);
    vec3 seen_n = vec3(dot(n, right), dot(n, up), max(dot(n, v), 0.0));
    float front = max(dot(seen_n, normalize(vec3(-0.45, 0.6, 0.66))), 0.0);
    float back = max(dot(seen_n, normalize(vec3(0.7, -0.3, 0.25))), 0.0);
    float glint = pow(max(dot(seen_n, normalize(vec3(-0.3, 0.42, 0.86))), 0.0), 40.0);
    vec3 sum = m.colour * (0.16 + 0.72 * front + 0.24 * back * back) * mix(0.4, 1.0, reach.y);
    return sum + 0.18 * glint;
}
#else
// Light towards v from a point with normal n; `reach` says which shares of the key light and of the
// light from all around get there.
vec3 shade(Material m, vec3 n, vec3 v, vec2 reach)
{
#if STYLE == CLAY
    m = Material(vec3(0.60, 0.50, 0.42), 0.65, 0.0);
#endif
    float key = reach.x, open = reach.y;
    vec3 l = to_light.xyz;
    vec3 diffuse = m.colour * (1.0 - m.metal);
    vec3 f0 = mix(vec3(0.04), m.colour, m.metal);
    float nl = dot(n, l), nv = max(dot(n, v), 0.02);

    vec3 sum = diffuse * hemisphere(n.y) * in_corner(diffuse, open);
    vec3 mirror = reflect(-v, n);
    vec4 r = m.rough * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float near_edge = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    vec2 reflected = vec2(-1.04, 1.04) * near_edge + r.zw;
    sum += (f0 * reflected.x + reflected.y) * hemisphere(mirror.y) * open;
    float behind = max(dot(n, rim.xyz), 0.0) * (1.0 - nv);
    sum += rim.w * open * behind * (0.5 * diffuse + 0.5 * (f0 + (1.0 - f0) * (1.0 - nv) * (1.0 - nv)));

    if (nl > 0.0 && key > 0.0) {
        vec3 h = normalize(l + v);
        float nh = max(dot(n, h), 0.0), lh = max(dot(l, h), 0.0);
        float a = max(m.rough * m.rough, 0.01), a2 = a * a;
        float d = nh * nh * (a2 - 1.0) + 1.0;
        float visible = 0.5 / mix(2.0 * nl * nv, nl + nv, a);
        vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - lh, 5.0);
        // `light` is what a white diffuse surface sends out, so 1 / pi is in it already.
        vec3 glint = min(a2 / (d * d) * visible, 16.0) * fresnel;
        sum += light.rgb * key * nl * (diffuse * (1.0 - fresnel) + glint);
    }
    return sum;
}
#endif

vec3 backdrop(vec3 ray)
{
    float up = clamp(normalize(ray).y, 0.0, 1.0);
    return mix(backdrop_horizon.rgb, backdrop_top.rgb, smoothstep(0.0, 0.75, up));
}

// The share of a pixel that lines of `width` (in cells) cover, on a grid of unit cells: the lines
// filtered over the pixel's footprint, so that far cells turn into an even grey.
float grid_cover(vec2 at, vec2 footprint, float width)
{
    vec2 w = max(footprint, 1e-6);
    vec2 wide = max(vec2(width), w);
    vec2 line = 1.0 - abs(fract(at) * 2.0 - 1.0);          // 0 on a line, 1 between
    vec2 cover = smoothstep(wide + 1.5 * w, max(wide - 1.5 * w, 0.0), line) * width / wide;
    cover = mix(cover, vec2(width), clamp(w * 2.0 - 1.0, 0.0, 1.0));
    return max(cover.x, cover.y);
}

// 0: colours for the eye; 1: linear light; 2: linear light without the backdrop, see Linear in look.hpp.
layout(location = 0) uniform int linear_out;

// The floor at depth t along `ray`; `reach` as for shade(). `stays`: what of it has not faded into
// the horizon.
vec3 floor_light(vec3 ray, float t, vec2 reach, out float stays)
{
    float key = reach.x;
    vec3 p = eye.xyz + t * ray;
    stays = 1.0 - smoothstep(2.0, FLOOR_REACH, length(p.xz));
    vec3 colour = floor_colour.rgb;
#if GRID == 1
    // How far the floor point moves from one pixel to the next.
    vec3 dx = t * (across.xyz - ray * (across.y / ray.y));
    vec3 dy = t * (down.xyz - ray * (down.y / ray.y));
    vec2 footprint = (abs(dx.xz) + abs(dy.xz)) / backdrop_top.w;
    vec2 at = (p.xz + shadow_size.zw) / backdrop_top.w;
    float fine = grid_cover(at, footprint, 0.02) * 0.35;
    float coarse = grid_cover(at * 0.1, footprint * 0.1, 0.004) * 0.55;
    colour *= 1.0 - max(fine, coarse) * stays;
#endif
#if STYLE == DIAGRAM
    vec3 lit = colour * (1.0 - 0.22 * (1.0 - key)) * mix(0.85, 1.0, reach.y);
#else
    vec3 lit = colour * (light.rgb * to_light.y * key + hemisphere(1.0) * reach.y);
#endif
    if (linear_out == 2) return lit * stays;
    return mix(backdrop_horizon.rgb, lit, stays);
}

float floor_depth(vec3 ray) { return (bounce.w - eye.y) / ray.y; }

// Khronos PBR Neutral: colours below 0.8 pass as they are, so that a material, or a colour of the
// legend, can be recognised; brighter ones are compressed and lose saturation towards white.
vec3 tone_map(vec3 colour)
{
    const float start = 0.8 - 0.04, desaturation = 0.15;
    float least = min(colour.r, min(colour.g, colour.b));
    float offset = least < 0.08 ? least - 6.25 * least * least : 0.04;
    colour -= offset;
    float peak = max(colour.r, max(colour.g, colour.b));
    if (peak < start) return colour;
    float room = 1.0 - start;
    float top = 1.0 - room * room / (peak + room - start);
    colour *= top / peak;
    return mix(colour, vec3(top), 1.0 - 1.0 / (desaturation * (peak - top) + 1.0));
}

// The sRGB curve to within 5e-5 (a fit of ours; powers are dear here and roots cheap).
vec3 srgb(vec3 linear)
{
    vec3 c = clamp(linear, 0.0, 1.0);
    vec3 s = sqrt(c), q = sqrt(s), e = sqrt(q);
    vec3 curve = 0.642375 * s + 0.712100 * q - 0.336866 * e - 0.0175664 * c;
    return mix(12.92 * c, curve, step(0.0031308, c));
}

// Ordered dither, +- half a level: smooth gradients come out without bands.
float dither(ivec2 at)
{
    int x = at.x ^ at.y, y = at.y;
    int order = (x & 1) << 5 | (y & 1) << 4 | (x & 2) << 2 | (y & 2) << 1 | (x & 4) >> 1 | (y & 4) >> 2;
    return (float(order) + 0.5) / 64.0 - 0.5;
}

// Colours for the eye carry their brightness with them, for the smoothing of edges.
vec4 shown(vec3 sum)
{
    vec3 c = srgb(sum);
    return vec4(c + dither(ivec2(gl_FragCoord.xy)) / 255.0, dot(c, vec3(0.299, 0.587, 0.114)));
}

// Of light that comes from what covers `cover` of the pixel.
vec4 finished(vec3 sum, float cover)
{
    if (linear_out == 0) return shown(tone_map(sum));
    return vec4(sum, linear_out == 1 ? 1.0 : cover);
}

vec3 ray_at(vec2 at) { return corner.xyz + at.x * across.xyz + at.y * down.xyz; }
