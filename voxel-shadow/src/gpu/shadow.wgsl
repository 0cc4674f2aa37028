// Queries of a voxelized shadow volume: the shader's side of `ShadowVolume`, in
// the spirit of the paper's appendix. Texels are read a word at a time, so
// that any number of bits per texel works and no vector component is selected at
// run time.
//
// Needs the parts `EPIPOLAR` and `PHI` of epipolar, and
//   fn vsv_word(index: u32) -> u32    the words of the grid

// Decided by distances instead of texels.
const vsv_LIT: u32 = 1u;
const vsv_DARK: u32 = 2u;

struct vsv_Sampling {
    alpha_bias: f32,
    phi_bias: f32,
    axis: f32,
    interpolate: u32,
}

// Voxels along φ that are equally visible; visibility 0 for none.
struct vsv_Run {
    start: f32,
    end: f32,
    visibility: f32,
}

// A lit part of a ray, in metres; visibility 0 for none.
struct vsv_LitInterval {
    start: f32,
    end: f32,
    visibility: f32,
}

// Two texels side by side along θ: where their words begin, and the share of the
// second.
struct vsv_Texels {
    first: u32,
    second: u32,
    share: f32,
    decided: u32,
}

// A ray, and how far its runs have been read.
struct vsv_Cursor {
    ray: epi_Ray,
    texels: vsv_Texels,
    surface: f32,
    end: f32,
    bit: u32,
    last: u32,
    start: f32,
    reached: f32,
    done: bool,
}

fn vsv_plane(l: epi_Lattice, theta: f32) -> u32 {
    let turn = f32(l.theta);
    var inside = theta;
    if l.wraps == 0u {
        inside = max(theta, 0.0);
    } else if theta < 0.0 {
        inside = theta + turn;
    } else if theta >= turn {
        inside = theta - turn;
    }
    return min(u32(max(inside, 0.0)), l.theta - 1u);
}

// The texels of a ray that ends at a surface.
fn vsv_texels(l: epi_Lattice, sampling: vsv_Sampling, ray: epi_Ray, surface: f32) -> vsv_Texels {
    let alpha = epi_alpha_position(l, ray.alpha);
    if l.starts_on_axis != 0u && alpha < sampling.axis {
        var distance = epi_FARTHEST;
        if l.directional == 0u {
            distance = min(l.distance, epi_FARTHEST);
        }
        return vsv_Texels(0u, 0u, 0.0, select(vsv_DARK, vsv_LIT, surface >= distance));
    }
    let row = u32(clamp(alpha + sampling.alpha_bias, 0.0, f32(l.alpha - 1u)));
    let theta = epi_theta_position(l, ray.theta);
    var below = floor(theta);
    var above = below;
    var share = 0.0;
    if sampling.interpolate != 0u {
        below = floor(theta - 0.5);
        above = below + 1.0;
        share = theta - 0.5 - below;
    }
    let words = l.bits / 32u;
    return vsv_Texels(
        (row * l.theta + vsv_plane(l, below)) * words,
        (row * l.theta + vsv_plane(l, above)) * words,
        share,
        0u,
    );
}

// The words of the two texels.
fn vsv_words(texels: vsv_Texels, word: u32) -> vec2<u32> {
    if texels.decided != 0u {
        return vec2(select(0u, 0xffffffffu, texels.decided == vsv_DARK));
    }
    return vec2(vsv_word(texels.first + word), vsv_word(texels.second + word));
}

fn vsv_blend(words: vec2<u32>, bit: u32, share: f32) -> f32 {
    let lit = vec2<f32>((~words >> vec2(bit % 32u)) & vec2(1u));
    return lit.x + share * (lit.y - lit.x);
}

// The visibility of a bit.
fn vsv_visibility_of(texels: vsv_Texels, bit: u32) -> f32 {
    return vsv_blend(vsv_words(texels, bit / 32u), bit, texels.share);
}

// The visibility at a position along φ, interpolated between bits.
fn vsv_sample(l: epi_Lattice, sampling: vsv_Sampling, texels: vsv_Texels, position: f32) -> f32 {
    let highest = f32(l.bits - 1u);
    let biased = position + sampling.phi_bias;
    if sampling.interpolate == 0u {
        return vsv_visibility_of(texels, u32(clamp(biased, 0.0, highest)));
    }
    let below = floor(biased - 0.5);
    let a = vsv_visibility_of(texels, u32(clamp(below, 0.0, highest)));
    let b = vsv_visibility_of(texels, u32(clamp(below + 1.0, 0.0, highest)));
    return a + (biased - 0.5 - below) * (b - a);
}

// The visibility of the light from a point on a visible surface.
fn vsv_visibility(l: epi_Lattice, sampling: vsv_Sampling, point: vec3<f32>) -> f32 {
    let from_eye = point - l.eye;
    let ray = epi_ray_to(l, point);
    let texels = vsv_texels(l, sampling, ray, length(from_eye));
    return vsv_sample(l, sampling, texels, epi_phi_position(l, epi_phi(l, ray, point)));
}

// The shadow along the eye ray into a direction, up to the first surface.
fn vsv_cursor(l: epi_Lattice, sampling: vsv_Sampling, direction: vec3<f32>, surface: f32) -> vsv_Cursor {
    var cursor: vsv_Cursor;
    cursor.ray = epi_ray(l, direction);
    cursor.surface = max(surface, 0.0);
    cursor.texels = vsv_texels(l, sampling, cursor.ray, cursor.surface);
    cursor.end = epi_phi_position(l, epi_phi_along(l, cursor.ray, cursor.surface));
    cursor.start = 0.0;
    cursor.reached = 0.0;
    cursor.done = false;
    let highest = f32(l.bits - 1u);
    cursor.bit = u32(clamp(sampling.phi_bias, 0.0, highest));
    cursor.last = u32(clamp(cursor.end + sampling.phi_bias, 0.0, highest));
    return cursor;
}

// The first bit above `bit` at which one of the texels changes, or the number
// of bits.
fn vsv_next_change(l: epi_Lattice, texels: vsv_Texels, bit: u32) -> u32 {
    var word = bit / 32u;
    let here = vsv_words(texels, word);
    // All ones for a texel whose bit is set.
    let ones = vec2(0u) - ((here >> vec2(bit % 32u)) & vec2(1u));
    let differs = here ^ ones;
    var found = (differs.x | differs.y) & (0xffffffffu << (bit % 32u));
    while found == 0u {
        word += 1u;
        if word >= l.bits / 32u {
            return l.bits;
        }
        let next = vsv_words(texels, word) ^ ones;
        found = next.x | next.y;
    }
    return 32u * word + firstTrailingBit(found);
}

// The next run that is not in full shadow.
fn vsv_next_run(l: epi_Lattice, sampling: vsv_Sampling, cursor: ptr<function, vsv_Cursor>) -> vsv_Run {
    while !(*cursor).done {
        let visibility = vsv_visibility_of((*cursor).texels, (*cursor).bit);
        let start = (*cursor).start;
        let change = vsv_next_change(l, (*cursor).texels, (*cursor).bit);
        // Helper invocations of a fragment shader may read anything: they come to an end, too.
        if change > (*cursor).last || change <= (*cursor).bit {
            (*cursor).done = true;
            (*cursor).start = (*cursor).end;
        } else {
            (*cursor).bit = change;
            (*cursor).start = min(f32(change) - sampling.phi_bias, (*cursor).end);
        }
        if visibility > 0.0 && (start < (*cursor).start || (*cursor).end == 0.0) {
            return vsv_Run(start, (*cursor).start, visibility);
        }
    }
    return vsv_Run(0.0, 0.0, 0.0);
}

fn vsv_distance(l: epi_Lattice, cursor: vsv_Cursor, position: f32) -> f32 {
    return min(epi_distance_along(l, cursor.ray, epi_phi_at(l, position)), cursor.surface);
}

// Where a run begins and ends; nowhere if it begins at infinity: a ray on the axis of a sun
// never comes to its second voxel.
fn vsv_interval(l: epi_Lattice, cursor: ptr<function, vsv_Cursor>, run: vsv_Run) -> vsv_LitInterval {
    var start = 0.0;
    if run.start > 0.0 {
        start = vsv_distance(l, *cursor, run.start);
    }
    var end = (*cursor).surface;
    if run.end < (*cursor).end {
        end = vsv_distance(l, *cursor, run.end);
    }
    start = max(start, (*cursor).reached);
    end = max(end, start);
    (*cursor).reached = end;
    if start >= epi_INFINITE {
        return vsv_LitInterval(0.0, 0.0, 0.0);
    }
    return vsv_LitInterval(start, end, run.visibility);
}

// The next lit part of the ray.
fn vsv_next_lit(l: epi_Lattice, sampling: vsv_Sampling, cursor: ptr<function, vsv_Cursor>) -> vsv_LitInterval {
    let run = vsv_next_run(l, sampling, cursor);
    if run.visibility <= 0.0 {
        return vsv_LitInterval(0.0, 0.0, 0.0);
    }
    return vsv_interval(l, cursor, run);
}

// The next lit voxel of the ray. `run` is what is left of the current run, at
// first one without length.
fn vsv_next_voxel(
    l: epi_Lattice,
    sampling: vsv_Sampling,
    cursor: ptr<function, vsv_Cursor>,
    run: ptr<function, vsv_Run>,
) -> vsv_LitInterval {
    if (*run).start >= (*run).end {
        *run = vsv_next_run(l, sampling, cursor);
        if (*run).visibility <= 0.0 {
            return vsv_LitInterval(0.0, 0.0, 0.0);
        }
    }
    var voxel = *run;
    // A ray on the axis has one run of no length, and no voxels.
    if (*cursor).texels.decided == 0u && (*cursor).end > 0.0 {
        var border = floor(voxel.start + sampling.phi_bias) + 1.0;
        // A border may be rounded down to where the run starts.
        if border - sampling.phi_bias <= voxel.start {
            border += 1.0;
        }
        voxel.end = min(voxel.end, border - sampling.phi_bias);
    }
    (*run).start = voxel.end;
    return vsv_interval(l, cursor, voxel);
}

// The position along φ at which the ray has gone a distance.
fn vsv_position(l: epi_Lattice, cursor: vsv_Cursor, distance: f32) -> f32 {
    return min(epi_phi_position(l, epi_phi_along(l, cursor.ray, max(distance, 0.0))), cursor.end);
}

// The share of the voxels between two distances that are lit; if there is no
// voxel between them the visibility at the first.
fn vsv_lit_fraction_between(
    l: epi_Lattice,
    sampling: vsv_Sampling,
    cursor: ptr<function, vsv_Cursor>,
    start: f32,
    end: f32,
) -> f32 {
    let first = vsv_position(l, *cursor, start);
    let last = vsv_position(l, *cursor, end);
    if !(first < last) {
        let bit = clamp(first + sampling.phi_bias, 0.0, f32(l.bits - 1u));
        return vsv_visibility_of((*cursor).texels, u32(bit));
    }
    var lit = 0.0;
    loop {
        let run = vsv_next_run(l, sampling, cursor);
        if run.visibility <= 0.0 {
            break;
        }
        lit += run.visibility * max(min(run.end, last) - max(run.start, first), 0.0);
    }
    return min(lit / (last - first), 1.0);
}

// The share of the voxels up to the surface that are lit.
fn vsv_lit_fraction(l: epi_Lattice, sampling: vsv_Sampling, cursor: ptr<function, vsv_Cursor>) -> f32 {
    var lit = 0.0;
    loop {
        let run = vsv_next_run(l, sampling, cursor);
        if run.visibility <= 0.0 {
            break;
        }
        if (*cursor).end == 0.0 {
            return run.visibility;
        }
        lit += run.visibility * (run.end - run.start);
    }
    if (*cursor).end > 0.0 {
        return min(lit / (*cursor).end, 1.0);
    }
    return 0.0;
}
