// Filtered precomputed shadows on surfaces: the shader's side of `FilteredShadows`.
//
// Needs the parts POINT, PACKED, SPACE and EXTENT of shadow-dag, grids.wgsl,
// baked_many.wgsl and
//   light_filter_width: u32    texels along each side of the window

// Where grids meet, a window that reaches over the rim of its grid has its rest in the next
// one: the shadowed shares of all grids add up, since everything outside of a grid is lit.
fn light_filtered_on_surface(point: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let bias = light_baked_lights[light_number()].bias;
    var shadowed = 0.0;
    for (var grid = 0u; grid < light_baked_count(); grid += 1u) {
        let here = light_baked_grid(grid);
        let h = dag_homogeneous(here.space, vec4(point, 1.0));
        if here.space.stretch > 0.0 && !(h.w > 0.0) {
            continue;
        }
        let turned = dag_normal(here.space, h, normal);
        let position = dag_position(here.space, h);
        let voxel = dag_bias_beyond(position, turned, light_filter_width, bias);
        shadowed += 1.0 - dag_filter(here.dag, voxel, light_filter_width);
    }
    return vec3(max(1.0 - shadowed, 0.0));
}
