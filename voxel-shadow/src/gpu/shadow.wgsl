// Queries of a voxelized shadow volume: the shader's side of `ShadowVolume`, in
// the spirit of the appendix of the paper (Wyman, "Voxelized Shadow Volumes", HPG 2011).
// A texel is a row of bits, one for each voxel along φ. Texels are read a word at a time, so
// that any number of bits per texel works and no vector component is selected at run time.
//
// Needs the parts `EPIPOLAR` and `PHI` of epipolar, and
//   fn vsv_word(index: u32) -> u32    the words of the grid

// Values of vsv_Texels.decided: rays next to the axis are decided by distances instead of
// texels.
const vsv_LIT: u32 = 1u;
const vsv_DARK: u32 = 2u;

// See `Sampling`.
struct vsv_Sampling {
    // Added to positions along α and along φ, in voxels, before a voxel is chosen.
    alpha_bias: f32,
    phi_bias: f32,
    // Rays closer to the axis, in voxels along α, are decided by distances.
    axis: f32,
    // Not 0 to interpolate between neighbours along θ, and between bits for points.
    interpolate: u32,
}

// A run of voxels along φ that are equally visible, as positions along φ; visibility 0 for
// none.
struct vsv_Run {
    start: f32,
    end: f32,
    visibility: f32,
}

// A lit part of a ray, as distances from the eye, m, with the share of the light that is
// seen there; visibility 0 for none.
struct vsv_LitInterval {
    start: f32,
    end: f32,
    visibility: f32,
}

// Two texels side by side along θ: where their words begin, and the share of the
// second. They are the same where nothing is interpolated.
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
    // Where the ray ends: its distance, m, and its position along φ.
    surface: f32,
    end: f32,
    // The bit at which the next run begins, and the last one that the ray comes to.
    bit: u32,
    last: u32,
    // The position along φ at which the next run begins.
    start: f32,
    // The distance at which the last interval ended, m.
    reached: f32,
    done: bool,
}

// The texel along θ at a position; around the axis θ wraps, elsewhere it ends.
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

// Word number `word` of both texels; a set bit is dark.
fn vsv_words(texels: vsv_Texels, word: u32) -> vec2<u32> {
    if texels.decided != 0u {
        return vec2(select(0u, 0xffffffffu, texels.decided == vsv_DARK));
    }
    return vec2(vsv_word(texels.first + word), vsv_word(texels.second + word));
}

// The visibility of a bit of two words, interpolated between the texels.
fn vsv_blend(words: vec2<u32>, bit: u32, share: f32) -> f32 {
    let lit = vec2<f32>((~words >> vec2(bit % 32u)) & vec2(1u));
    return lit.x + share * (lit.y - lit.x);
}

// The visibility of a bit of the texels.
fn vsv_visibility_of(texels: vsv_Texels, bit: u32) -> f32 {
    return vsv_blend(vsv_words(texels, bit / 32u), bit, texels.share);
}

// The visibility at a position along φ, interpolated between bits if the sampling says so.
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

// The visibility of the light, 0 to 1, from a point that the eye sees on a surface.
fn vsv_visibility(l: epi_Lattice, sampling: vsv_Sampling, point: vec3<f32>) -> f32 {
    let from_eye = point - l.eye;
    let ray = epi_ray_to(l, point);
    let texels = vsv_texels(l, sampling, ray, length(from_eye));
    return vsv_sample(l, sampling, texels, epi_phi_position(l, epi_phi(l, ray, point)));
}

// Begins to read the shadow along the eye ray into a direction of any length, up to the
// first surface, whose distance is in m; epi_INFINITE for none.
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
    // All ones for a texel whose bit is set, so that the xor shows where it changes.
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

// The next run that is not in full shadow; visibility 0 behind the last one.
fn vsv_next_run(l: epi_Lattice, sampling: vsv_Sampling, cursor: ptr<function, vsv_Cursor>) -> vsv_Run {
    while !(*cursor).done {
        let visibility = vsv_visibility_of((*cursor).texels, (*cursor).bit);
        let start = (*cursor).start;
        let change = vsv_next_change(l, (*cursor).texels, (*cursor).bit);
        // The second condition makes the loop end whatever is read: helper invocations of a
        // fragment shader may read anything.
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

// The distance of a position along φ, m, at most that of the surface.
fn vsv_distance(l: epi_Lattice, cursor: vsv_Cursor, position: f32) -> f32 {
    return min(epi_distance_along(l, cursor.ray, epi_phi_at(l, position)), cursor.surface);
}

// A run as an interval of distances; visibility 0 if it begins at infinity, since a ray on
// the axis of a sun never comes to its second voxel. Intervals do not overlap.
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

// The next lit part of the ray; visibility 0 behind the last one.
fn vsv_next_lit(l: epi_Lattice, sampling: vsv_Sampling, cursor: ptr<function, vsv_Cursor>) -> vsv_LitInterval {
    let run = vsv_next_run(l, sampling, cursor);
    if run.visibility <= 0.0 {
        return vsv_LitInterval(0.0, 0.0, 0.0);
    }
    return vsv_interval(l, cursor, run);
}

// The next lit voxel of the ray; visibility 0 behind the last one. `run` is what is left of
// the current run: begin with one without length.
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

// The position along φ at which the ray has gone a distance, m.
fn vsv_position(l: epi_Lattice, cursor: vsv_Cursor, distance: f32) -> f32 {
    return min(epi_phi_position(l, epi_phi_along(l, cursor.ray, max(distance, 0.0))), cursor.end);
}

// The share of the voxels between two distances, m, that are lit; if there is no voxel
// between them, the visibility at the first. Reads all runs that are left.
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

// The share of the voxels up to the surface that are lit. Reads all runs that are left.
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
