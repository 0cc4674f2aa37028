// Visibility: slabs parallel to the picture; the visibility at the middle plane of each holds
// for the slab.
//
// Needs the variable
//   light_slices: light_Slices
// and the slot of the point visibility,
//   fn light_point_visibility(point: vec3<f32>) -> vec3<f32>

// The cosine of the largest angle between a ray and the axis.
const light_slices_LEAST_COS: f32 = 1.8e-3;

struct light_Slices {
    forward: vec3<f32>,
    // The thickness of a slab along the axis, m.
    thickness: f32,
    count: u32,
    // The depth of the first slab, m.
    near: f32,
    padding_a: u32,
    padding_b: u32,
}

struct light_slices_Cursor {
    // The same along the ray.
    near: f32,
    thickness: f32,
    // The number of the next slab.
    slab: u32,
}

fn light_slices_cursor(path: light_Path) -> light_slices_Cursor {
    let cos = max(dot(path.direction, light_slices.forward), light_slices_LEAST_COS);
    let thickness = light_slices.thickness / cos;
    if !(thickness > 0.0) {
        return light_slices_Cursor(0.0, 0.0, light_slices.count);
    }
    // Slabs in front of the path are skipped.
    let near = light_slices.near / cos;
    let first = clamp((path.start - near) / thickness, 0.0, f32(light_slices.count));
    return light_slices_Cursor(near, thickness, u32(first));
}

fn light_slices_next_lit(cursor: ptr<function, light_slices_Cursor>, path: light_Path) -> light_Lit {
    let near = (*cursor).near;
    let thickness = (*cursor).thickness;
    while (*cursor).slab < light_slices.count {
        let i = f32((*cursor).slab);
        (*cursor).slab += 1u;
        let start = near + i * thickness;
        if start >= path.end {
            (*cursor).slab = light_slices.count;
            break;
        }
        let plane = near + (i + 0.5) * thickness;
        if plane < path.start || plane >= path.end {
            continue;
        }
        let visibility = light_point_visibility(path.origin + plane * path.direction);
        let end = near + (i + 1.0) * thickness;
        let part = light_Lit(max(start, path.start), min(end, path.end), visibility);
        if !light_is_dark(part) {
            return part;
        }
    }
    return light_dark();
}
