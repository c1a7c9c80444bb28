// Layers of what is clear, from near to far.
#if PEEL == 1
layout(location = 8) uniform int behind;  // 1: only what lies behind the layer of these depths
layout(binding = 13) uniform sampler2D layer_before;

// Where a layer of these depths ends, as stored: what is so near to its depth lies on it, and in no
// order but that of the scene. Faces of one plane, of other triangles, differ by the rounding of
// single precision, 6e-8 of the distance to the eye and a few times that.
float end_of(sampler2D depths)
{
    float stored = texelFetch(depths, ivec2(gl_FragCoord.xy), 0).x;
    return stored - 5e-7 * (stored + eye.w / (corner.w - eye.w));
}

bool in_layers_before() { return behind == 1 && gl_FragCoord.z >= end_of(layer_before); }
#endif
