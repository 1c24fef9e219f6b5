// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Section through the volume: window and level to grey; optionally the threshold as a line.

in vec2 place;
out vec4 colour;

uniform vec3 centre, right, up;  // [mm, LPS]; unit vectors
uniform vec2 halfExtent;         // of the picture [mm]
uniform float window, level;     // [HU]
uniform float iso;               // [HU]
uniform bool contour;
uniform float pixel;  // size [mm]

void main() {
    vec3 world = centre + place.x * halfExtent.x * right + place.y * halfExtent.y * up;
    vec3 p = voxelOf(world);
    if (any(lessThan(p, vec3(-0.5))) || any(greaterThan(p, size - 0.5))) {
        colour = vec4(0.0, 0.0, 0.0, 1.0);
        return;
    }
    float value = quickSample(p);
    float grey = clamp((slabAt(p) - level) / max(window, 1e-6) + 0.5, 0.0, 1.0);
    vec3 shade = vec3(grey);
    vec4 over = overlayAt(p);
    shade = mix(shade, over.rgb, over.a);
#ifdef LABELS
    vec4 label = labelOutlined(p, voxelVectorOf(pixel * right), voxelVectorOf(pixel * up));
    shade = mix(shade, label.rgb, label.a);
    vec4 contact = contactShade(p);
    shade = mix(shade, contact.rgb, contact.a);
#endif
    if (contour) {
        vec3 dx = voxelVectorOf(pixel * right), dy = voxelVectorOf(pixel * up);
        float gx = quickSample(p + dx) - quickSample(p - dx);
        float gy = quickSample(p + dy) - quickSample(p - dy);
        float steepness = 0.5 * length(vec2(gx, gy));  // per pixel
        float line = 1.0 - clamp(abs(value - iso) / max(steepness, 1e-3) - 0.3, 0.0, 1.0);
        shade = mix(shade, vec3(0.95, 0.55, 0.35), 0.85 * line);
    }
    colour = vec4(shade, 1.0);
}
