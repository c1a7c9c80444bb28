#version 450 core
// Shared by all shaders: the numbers of a frame. Mirrors FrameNumbers in draw_job.hpp.
layout(std140, binding = 0) uniform Frame {
    mat4 clip_from_stage;
    mat4 shadow_from_stage;
    vec4 units;    // xyz centre of the stage in metres, w stage units per metre
    vec4 eye;      // w depth at the near plane
    vec4 corner;   // w depth at the far plane
    vec4 across;   // w picture width, pixels
    vec4 down;     // w picture height, pixels
    vec4 to_light; // w 1 when there is a shadow map
    vec4 light;    // w texel of the shadow map, stage units
    vec4 sky;      // w 1 when there is a floor
    vec4 bounce;   // w height of the floor
    vec4 backdrop_top;      // w grid spacing; 0 none
    vec4 backdrop_horizon;  // w 1: clear things are glass, with lighter shadows
    vec4 floor_colour;      // w samples along each side of a pixel
    vec4 shadow_size;       // xy texels, zw where the stage's centre is on the grid
    vec4 soft;     // x tangent of the key light's half width, y shadow depth per stage unit, z strength of occlusion, w its reach
    vec4 rim;      // to the light from behind; w its strength
    vec4 drawn_low, drawn_high;  // the box of all that is drawn; w of the first: a turn of soft light's discs
    mat4 far_from_stage;
    vec4 far_size; // xy texels of the far shadow map, z one of them, stage units
};
const float FLOOR_REACH = 9.0;  // stage units: there the floor has faded into the horizon
// Stage units by which the floor's depth lies below it: a sheet that lies on the floor hides it, and
// not here and there as depths are rounded.
const float FLOOR_LOWERED = 1e-3;
