// Curves whose nodes hold optical depths, between which transmittance runs
// exponentially: the rules of `Exponential`.

const avsm_CLEAR: f32 = 0.0;

fn avsm_transmittance(value: f32) -> f32 {
    return avsm_exp_neg(value);
}

// The value of a transmittance above 0.
fn avsm_value(transmittance: f32) -> f32 {
    return max(0.0 - log(transmittance), 0.0);
}

// Share of the optical depth that roundings can have changed: 2 u for each of
// the counted insertions.
fn avsm_share_rounded(insertions: u32) -> f32 {
    return f32(insertions) * 1.1920930e-7;
}

// Least and most of the exact transmittance at a node, to 4e-7.
fn avsm_range(value: f32, below: f32, above: f32, insertions: u32) -> vec2<f32> {
    let rounding = avsm_share_rounded(insertions) * value;
    return vec2(
        avsm_exp_neg(value + above + rounding),
        avsm_exp_neg(max(value - below - rounding, 0.0)),
    );
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
    let falls_to = avsm_exp_neg(values.y * (1.0 + share));
    let up = min(first.y * avsm_lost(below), first.y - falls_to);
    let down = min(falls_from * avsm_lost(above), falls_from - last.x);
    let at = min(max(1.0 / (1.0 - share), values.x), values.y);
    return max(max(up, down), 0.0) + share * at * avsm_exp_neg(at * (1.0 - share));
}
