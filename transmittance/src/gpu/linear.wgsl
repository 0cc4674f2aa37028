// Curves whose nodes hold transmittances, interpolated linearly: the rules of
// `Linear`.

const avsm_CLEAR: f32 = 1.0;

// Beyond any transmittance: linear curves cut nothing off.
const avsm_DARK: f32 = 0x1p+100;

fn avsm_transmittance(value: f32) -> f32 {
    return value;
}

// The value of a transmittance above 0.
fn avsm_value(transmittance: f32) -> f32 {
    return transmittance;
}

// By how much roundings can have changed a transmittance: 4 u for each counted insertion.
fn avsm_roundings(value: f32, insertions: u32) -> f32 {
    return f32(insertions) * 2.4e-7 * value;
}

// Least and most of the exact transmittance at a node, to 4e-7.
fn avsm_range(value: f32, below: f32, above: f32, insertions: u32) -> vec2<f32> {
    let rounding = avsm_roundings(value, insertions);
    return vec2(max(value - below - rounding, 0.0), min(value + above + rounding, 1.0));
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
    let rounding = avsm_roundings(values.x, insertions);
    let up = min(above + rounding, first.y - values.y);
    let down = min(below + rounding, values.x - last.x);
    return max(max(up, down), 0.0);
}
