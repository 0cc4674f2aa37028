// Questions to stored curves. Needs the constants avsm_NODES and avsm_CHANNELS,
// the part numeric.wgsl, one of exponential.wgsl and linear.wgsl, and one of
// packed.wgsl, half.wgsl and bounded.wgsl.

// The number of nodes in front of a depth; 0 for NaN. The search has two levels: every
// fourth node tells the group, whose own nodes tell the rest.
fn avsm_find(texel: u32, depth: f32) -> u32 {
    let bits = bitcast<u32>(depth);
    let len = avsm_stored_len(texel);
    if bits == 0x7f800000u {
        return len;
    }
    // NaN, and −infinity, which is in front of everything.
    if !avsm_is_finite(depth) {
        return 0u;
    }
    let place = avsm_place(texel, depth);
    var start = 0u;
    for (var i = 3u; i < avsm_NODES; i += 4u) {
        start += select(0u, 4u, i < len && avsm_stored_depth(texel, i) < place);
    }
    var count = start;
    for (var i = 0u; i < 4u; i++) {
        let node = start + i;
        count += u32(node < len && avsm_stored_depth(texel, min(node, avsm_NODES - 1u)) < place);
    }
    return count;
}

// Share of the light that gets as far as a depth, per channel. What is exactly
// at the depth casts no shadow on it.
fn avsm_transmittances(texel: u32, depth: f32) -> array<f32, avsm_CHANNELS> {
    var result: array<f32, avsm_CHANNELS>;
    let next = avsm_find(texel, depth);
    if next == 0u {
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            result[c] = 1.0;
        }
        return result;
    }
    let first = next - 1u;
    let last = min(next, avsm_stored_len(texel) - 1u);
    var share = 0.0;
    if first < last {
        let ends = vec2(avsm_stored_depth(texel, first), avsm_stored_depth(texel, last));
        share = avsm_shares(ends, avsm_place(texel, depth)).y;
    }
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        let front = avsm_stored_value(texel, first, c);
        let back = avsm_stored_value(texel, last, c);
        // Clamped, so that rounding never makes it rise with depth.
        let value = clamp(front + (back - front) * share, min(front, back), max(front, back));
        result[c] = avsm_transmittance(value);
    }
    return result;
}

// The largest depth to which at least the share `transmittance` of the light gets in a
// channel: avsm_LARGEST if the curve never falls below it, -avsm_LARGEST for shares above 1.
fn avsm_depth_at(texel: u32, transmittance: f32, channel: u32) -> f32 {
    if transmittance > 1.0 {
        return -avsm_LARGEST;
    }
    let len = avsm_stored_len(texel);
    for (var next = 1u; next < avsm_NODES; next++) {
        if next >= len {
            break;
        }
        let back = avsm_stored_value(texel, next, channel);
        if avsm_transmittance(back) < transmittance {
            let front = avsm_stored_value(texel, next - 1u, channel);
            var share = 0.0;
            if front != back {
                share = clamp((avsm_value(transmittance) - front) / (back - front), 0.0, 1.0);
            }
            let ends = vec2(avsm_stored_depth(texel, next - 1u), avsm_stored_depth(texel, next));
            let place = clamp(ends.x * (1.0 - share) + ends.y * share, ends.x, ends.y);
            return avsm_unplace(texel, place);
        }
    }
    return avsm_LARGEST;
}
