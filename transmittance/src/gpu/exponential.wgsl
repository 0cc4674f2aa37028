// Curves whose nodes hold optical depths, between which transmittance runs
// exponentially: the rules of `Exponential`.

const avsm_CLEAR: f32 = 0.0;

// Optical depths from here on all count as opaque: e^-128 is below 1e-55.
const avsm_DARK: f32 = 128.0;

fn avsm_transmittance(value: f32) -> f32 {
    return avsm_exp_neg(value);
}

// The optical depth of a transmittance above 0.
fn avsm_value(transmittance: f32) -> f32 {
    return max(0.0 - log(transmittance), 0.0);
}

// The share of an optical depth that roundings can have changed: 2 u for each counted
// insertion.
fn avsm_share_rounded(insertions: u32) -> f32 {
    return f32(insertions) * 1.1920930e-7;
}

// Least and most of the exact transmittance at a node, to 1e-6. Optical depths are widened
// by 1e-6 of themselves for roundings, which count where large ones cancel.
fn avsm_range(value: f32, below: f32, above: f32, insertions: u32) -> vec2<f32> {
    let rounding = avsm_share_rounded(insertions) * value;
    let shallowest = min(value - rounding, avsm_DARK) * 0.999999 - below * 1.000001;
    return vec2(avsm_exp_neg(value + above + rounding), avsm_exp_neg(max(shallowest, 0.0)));
}

// The largest error on a stretch between two values; `first` and `last` are the
// exact transmittances at its ends as `avsm_range` has them.
fn avsm_stretch_error(
    values: vec2<f32>,
    below: f32,
    above: f32,
    first: vec2<f32>,
    last: vec2<f32>,
    insertions: u32,
) -> f32 {
    let share = avsm_share_rounded(insertions);
    if share > 0.5 {
        return 1.0;
    }
    // See `Rules::error` on the CPU.
    let falls_from = avsm_exp_neg(values.x * (1.0 - share));
    let falls_to = avsm_exp_neg(min(values.y * (1.0 + share), avsm_DARK));
    let shallowest = min(values.x * (1.0 - share), avsm_DARK) * 0.999999 - below * 1.000001;
    let reached = avsm_exp_neg(max(shallowest, 0.0));
    var up = min(min(first.y, reached) * avsm_lost(below), first.y - falls_to);
    if values.y * (1.0 + share) > 0.999999 * avsm_DARK {
        let from_dark = avsm_exp_neg(max(avsm_DARK * 0.999999 - below * 1.000001, 0.0));
        up = max(up, min(first.y, from_dark));
    }
    let down = min(falls_from * avsm_lost(above), falls_from - last.x);
    let at = min(max(1.0 / (1.0 - share), values.x), values.y);
    return max(max(up, down), 0.0) + share * at * avsm_exp_neg(at * (1.0 - share));
}
