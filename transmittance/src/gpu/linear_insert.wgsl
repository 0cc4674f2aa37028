// How curves with linear lookup are made: the rules of `Linear`. Needs the parts
// linear.wgsl and curve.wgsl.

// Makes up for the roundings of a bound's own arithmetic.
const avsm_INFLATE: f32 = 1.000001;

// An upper bound of the distance between exp(-tau f), 0 <= f <= 1, and its chord, from the
// function and its tangent at the middle; `passed` is exp(-tau). 4e-7 of it are for
// roundings.
fn avsm_sag(tau: f32, passed: f32) -> f32 {
    let middle = avsm_exp_neg(0.5 * tau);
    // From an optical depth of 200 on the product is 0.
    let slope = (1.0 - passed) - min(tau, 200.0) * middle;
    let lost = 1.0 - middle;
    // For a small optical depth the slope is a difference of near equals, but the distance
    // is at most tau²/8.
    let small = min(tau, 4.0);
    return 0.5 * min(lost * lost + abs(slope), 0.25 * small * small) + 4e-7;
}

// Multiplies the curve by a segment, from the node `first` at its entry on; the
// node `after` is at its exit.
fn avsm_attenuate(
    curve: ptr<function, avsm_Curve>,
    first: u32,
    after: u32,
    segment: avsm_Segment,
) {
    let ends = vec2(segment.entry, segment.exit);
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        let row = c * avsm_CAPACITY;
        let passed = avsm_exp_neg(segment.optical_depth[c]);
        var sag = 0.0;
        if ends.x < ends.y {
            sag = avsm_sag(segment.optical_depth[c], passed);
        }
        // The segment's factor at the start of a stretch.
        var here = 1.0;
        for (var i = 0u; i < avsm_CAPACITY; i++) {
            if i < first || i >= (*curve).len {
                continue;
            }
            let value = (*curve).value[row + i];
            if i >= after {
                (*curve).value[row + i] = value * passed;
                (*curve).above[row + i] *= passed * avsm_INFLATE;
                (*curve).below[row + i] *= passed * avsm_INFLATE;
                continue;
            }
            var next = passed;
            if i + 1u < after {
                // Rounding must not make the factor rise.
                let shares = avsm_shares(ends, (*curve).depth[i + 1u]);
                next = min(avsm_mix(vec2(1.0, passed), shares), here);
            }
            // The exact factor lies up to `sag` below its chord, and the product
            // of two chords below the chord of the product by at most a quarter
            // of what both lose.
            let bend = 0.25 * (value - (*curve).value[row + i + 1u]) * (here - next);
            let below = (*curve).below[row + i] * here + value * sag + bend;
            (*curve).value[row + i] = value * here;
            (*curve).above[row + i] *= here * avsm_INFLATE;
            (*curve).below[row + i] = below * avsm_INFLATE;
            here = next;
        }
    }
}

// Area between the curve through three nodes and the curve through the outer two, which
// is that of a triangle.
fn avsm_area(widths: vec2<f32>, values: vec3<f32>, transmittances: vec3<f32>) -> f32 {
    let steps = values.yx - values.zy;
    return 0.5 * abs(widths.x * steps.x - widths.y * steps.y);
}

// The error of a stretch where the exact value is within `below` and `above` of the curve:
// an estimate for choosing nodes, not a bound.
fn avsm_spread(transmittances: vec2<f32>, below: f32, above: f32) -> f32 {
    let all = max(transmittances.x - transmittances.y, 0.0);
    return min(max(below, above), all + min(below, above));
}
