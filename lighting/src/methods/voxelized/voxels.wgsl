// Visibility: the voxels of a ray; the shader's side of `VoxelShadow`.
//
// Needs the parts EPIPOLAR and PHI of epipolar, SHADOW of voxel-shadow and what they
// need, and
//   fn light_voxels() -> light_Voxels    the voxels of the light

struct light_Voxels {
    lattice: epi_Lattice,
    sampling: vsv_Sampling,
    // What is read from the voxels: one of the constants below.
    detail: u32,
    // Whether the volume knows that all rays are lit, or that all are dark.
    state: u32,
}

// Values of `detail`: the average along the ray, each voxel, or runs of equal voxels.
const light_AVERAGE: u32 = 0u;
const light_VOXELS: u32 = 1u;
const light_RUNS: u32 = 2u;

// Values of `state`; with larger ones the voxels decide.
const light_ALL_LIT: u32 = 0u;
const light_ALL_DARK: u32 = 1u;

struct light_voxels_Cursor {
    shadow: vsv_Cursor,
    // What is left of a run that is read voxel by voxel.
    run: vsv_Run,
    // Whether one visibility holds for the whole path, and which.
    average: f32,
    is_one: bool,
    done: bool,
}

fn light_voxels_cursor(path: light_Path) -> light_voxels_Cursor {
    var cursor: light_voxels_Cursor;
    cursor.run = vsv_Run(0.0, 0.0, 0.0);
    cursor.done = false;
    let voxels = light_voxels();
    let state = voxels.state;
    cursor.is_one = state <= light_ALL_DARK;
    cursor.average = select(0.0, 1.0, state == light_ALL_LIT);
    if cursor.is_one {
        return cursor;
    }
    let l = voxels.lattice;
    let sampling = voxels.sampling;
    var shadow = vsv_cursor(l, sampling, path.direction, path.surface);
    if voxels.detail == light_AVERAGE {
        cursor.is_one = true;
        cursor.average = vsv_lit_fraction_between(l, sampling, &shadow, path.start, path.end);
    }
    cursor.shadow = shadow;
    return cursor;
}

fn light_voxels_next_lit(cursor: ptr<function, light_voxels_Cursor>, path: light_Path) -> light_Lit {
    if (*cursor).is_one {
        if (*cursor).done {
            return light_dark();
        }
        (*cursor).done = true;
        return light_lit(path.start, path.end, (*cursor).average);
    }
    let voxels = light_voxels();
    let l = voxels.lattice;
    let sampling = voxels.sampling;
    var shadow = (*cursor).shadow;
    var run = (*cursor).run;
    var found = light_dark();
    loop {
        var part: vsv_LitInterval;
        if voxels.detail == light_VOXELS {
            part = vsv_next_voxel(l, sampling, &shadow, &run);
        } else {
            part = vsv_next_lit(l, sampling, &shadow);
        }
        let start = max(part.start, path.start);
        let end = min(part.end, path.end);
        if part.visibility <= 0.0 {
            break;
        }
        if start < end {
            found = light_lit(start, end, part.visibility);
            break;
        }
    }
    (*cursor).shadow = shadow;
    (*cursor).run = run;
    return found;
}
