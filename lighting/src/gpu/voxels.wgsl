// Visibility: the voxels of a ray; the shader's side of `VoxelShadow`.
//
// Needs the parts EPIPOLAR and PHI of epipolar, SHADOW of voxel-shadow, and
//   fn light_voxel_lattice() -> epi_Lattice
//   fn light_voxel_sampling() -> vsv_Sampling
//   fn light_voxel_detail() -> u32      what is read from the voxels
//   fn light_voxel_state() -> u32       what the volume says of all rays

const light_AVERAGE: u32 = 0u;
const light_VOXELS: u32 = 1u;
const light_RUNS: u32 = 2u;

const light_ALL_LIT: u32 = 0u;
const light_ALL_DARK: u32 = 1u;

struct light_Look {
    shadow: vsv_Cursor,
    // What is left of a run that is read voxel by voxel.
    run: vsv_Run,
    // The visibility of all of the span, if there is but one.
    average: f32,
    is_one: bool,
    done: bool,
}

fn light_look(path: light_Path) -> light_Look {
    var look: light_Look;
    look.run = vsv_Run(0.0, 0.0, 0.0);
    look.done = false;
    let state = light_voxel_state();
    look.is_one = state <= light_ALL_DARK;
    look.average = select(0.0, 1.0, state == light_ALL_LIT);
    if look.is_one {
        return look;
    }
    let l = light_voxel_lattice();
    let sampling = light_voxel_sampling();
    var shadow = vsv_cursor(l, sampling, path.direction, path.surface);
    if light_voxel_detail() == light_AVERAGE {
        look.is_one = true;
        look.average = vsv_lit_fraction_between(l, sampling, &shadow, path.start, path.end);
    }
    look.shadow = shadow;
    return look;
}

fn light_next_lit(look: ptr<function, light_Look>, path: light_Path) -> light_Lit {
    if (*look).is_one {
        if (*look).done {
            return light_Lit(0.0, 0.0, 0.0);
        }
        (*look).done = true;
        return light_Lit(path.start, path.end, (*look).average);
    }
    let l = light_voxel_lattice();
    let sampling = light_voxel_sampling();
    var shadow = (*look).shadow;
    var run = (*look).run;
    var found = light_Lit(0.0, 0.0, 0.0);
    loop {
        var part: vsv_LitInterval;
        if light_voxel_detail() == light_VOXELS {
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
            found = light_Lit(start, end, part.visibility);
            break;
        }
    }
    (*look).shadow = shadow;
    (*look).run = run;
    return found;
}
