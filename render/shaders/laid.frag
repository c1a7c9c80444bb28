// What another pass drew, to be laid over or under what is there.
layout(location = 0) out vec4 colour;

layout(binding = 0) uniform sampler2D drawn;

void main() { colour = texelFetch(drawn, ivec2(gl_FragCoord.xy), 0); }
