// How curves with exponential lookup are made: the rules of `Exponential`. Needs the parts
// exponential.wgsl and curve.wgsl.

// Multiplies the curve by a segment, from the node `first` at its entry on; the
// node `after` is at its exit.
fn avsm_attenuate(
    curve: ptr<function, avsm_Curve>,
    first: u32,
    after: u32,
    segment: avsm_Segment,
) {
    let ends = vec2(segment.entry, segment.exit);
    for (var i = 1u; i < avsm_CAPACITY; i++) {
        if i <= first || i >= (*curve).len {
            continue;
        }
        var share = 1.0;
        if i < after {
            share = avsm_shares(ends, (*curve).depth[i]).y;
        }
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            let value = (*curve).value[c * avsm_CAPACITY + i];
            // Where no light is left, values stop growing before they overflow.
            let sum = value + segment.optical_depth[c] * share;
            (*curve).value[c * avsm_CAPACITY + i] = min(sum, 1e38);
        }
    }
}

// The mean transmittance of a stretch over which the optical depth grows by u:
// (T0 - T1) / u. Where the difference loses its digits, the same as a series: the mean of
// the ends times tanh(u/2) / (u/2).
fn avsm_mean(u: f32, transmittances: vec2<f32>) -> f32 {
    let v = min(u, 1.0);
    let v2 = v * v;
    let series = 1.0 - v2 * (1.0 / 12.0 - v2 * (1.0 / 120.0 - v2 * (17.0 / 20160.0)));
    let mean = 0.5 * (transmittances.x + transmittances.y);
    let quotient = (transmittances.x - transmittances.y) / max(u, 0.1);
    return select(mean * series, quotient, u > 0.5);
}

// Area between the curve through three nodes and the curve through the outer
// two.
fn avsm_area(widths: vec2<f32>, values: vec3<f32>, transmittances: vec3<f32>) -> f32 {
    let both = avsm_mean(values.z - values.x, transmittances.xz);
    let front = avsm_mean(values.y - values.x, transmittances.xy);
    let back = avsm_mean(values.z - values.y, transmittances.yz);
    return abs(widths.x * (front - both) + widths.y * (back - both));
}

// The error of a stretch where the exact value is within `below` and `above` of the curve:
// an estimate for choosing nodes, not a bound.
fn avsm_spread(transmittances: vec2<f32>, below: f32, above: f32) -> f32 {
    let bound = transmittances.x * (1.0 - avsm_exp_neg(max(below, above)));
    return min(bound, transmittances.x - transmittances.y);
}
