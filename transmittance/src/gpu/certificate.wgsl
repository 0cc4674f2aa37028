// Error bounds of curves that are stored with them. Needs the parts bounded.wgsl
// and lookup.wgsl.

// The least and the most of the exact transmittance at a node. At an inner node both
// stretches hold, so that the narrower bound counts; at the first and the last node there
// is no error but rounding.
fn avsm_end_range(texel: u32, node: u32, channel: u32, len: u32, insertions: u32) -> vec2<f32> {
    var above = 0.0;
    var below = 0.0;
    if node > 0u && node + 1u < len {
        let row = 1u + avsm_CHANNELS + channel;
        above = min(
            avsm_stored_number(texel, row, node - 1u),
            avsm_stored_number(texel, row, node),
        );
        below = min(
            avsm_stored_number(texel, row + avsm_CHANNELS, node - 1u),
            avsm_stored_number(texel, row + avsm_CHANNELS, node),
        );
    }
    return avsm_range(avsm_stored_value(texel, node, channel), below, above, insertions);
}

// An upper bound of the absolute error of `avsm_transmittances` at a depth, per channel,
// at most 1. 2e-6 of it are for the arithmetic of the bound and of the lookup.
fn avsm_error_bounds(texel: u32, depth: f32) -> array<f32, avsm_CHANNELS> {
    var bounds: array<f32, avsm_CHANNELS>;
    let len = avsm_stored_len(texel);
    let insertions = avsm_word(texel * avsm_WORDS + 1u);
    // Segments are missing, and may lie in front of the first node.
    if insertions == avsm_INCOMPLETE {
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            bounds[c] = 1.0;
        }
        return bounds;
    }
    let next = avsm_find(texel, depth);
    if next == 0u {
        return bounds;
    }
    let first = next - 1u;
    let last = min(next, len - 1u);
    let ends = vec2(avsm_stored_depth(texel, first), avsm_stored_depth(texel, last));
    // A depth that finds this stretch lies behind its first node, by at least one float.
    let behind = avsm_next_up(ends.x);
    let share = select(1.0, avsm_shares(ends, behind).y * 0.999999, behind < ends.y);
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        let front = avsm_stored_value(texel, first, c);
        let back = avsm_stored_value(texel, last, c);
        let error = avsm_stretch_error(
            vec2(front + (back - front) * share, back),
            avsm_stored_number(texel, 1u + 2u * avsm_CHANNELS + c, first),
            avsm_stored_number(texel, 1u + avsm_CHANNELS + c, first),
            avsm_end_range(texel, first, c, len, insertions),
            avsm_end_range(texel, last, c, len, insertions),
            insertions,
        );
        bounds[c] = min(error + 2e-6, 1.0);
    }
    return bounds;
}
