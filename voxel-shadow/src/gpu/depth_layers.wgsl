// The first blocker by depths that a renderer has drawn: the shader's side of
// `DepthViews`. Needs the part depth.wgsl and the variables
//   vsv_depth_views: vsv_DepthViews
//   vsv_depth_layers: texture_depth_2d_array

struct vsv_DepthViews {
    matrices: array<mat4x4<f32>, 16>,
    count: u32,
    // The depth of texels in which nothing was drawn.
    empty: f32,
}

// The distance along a light ray to the first blocker, by the first view that shows one;
// epi_INFINITE if none does.
fn vsv_layers_first_blocker(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let views = min(vsv_depth_views.count, textureNumLayers(vsv_depth_layers));
    for (var view = 0u; view < views; view += 1u) {
        let matrix = vsv_depth_views.matrices[view];
        let place = vsv_depth_place(matrix, origin, direction);
        if place.z <= 0.0 {
            continue;
        }
        let size = textureDimensions(vsv_depth_layers);
        let texel = min(vec2<u32>(place.xy * vec2<f32>(size)), size - vec2(1u));
        let depth = textureLoad(vsv_depth_layers, texel, view, 0);
        if depth != vsv_depth_views.empty {
            return vsv_depth_distance(matrix, origin, direction, depth);
        }
    }
    return epi_INFINITE;
}
