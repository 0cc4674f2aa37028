// What it costs to remove the inner node q: the error on the stretch that this leaves, as
// `Maximum` measures it.
fn avsm_cost(
    curve: ptr<function, avsm_Curve>,
    transmittances: ptr<function, array<f32, avsm_VALUES>>,
    q: u32,
) -> f32 {
    var cost = 0.0;
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        let i = c * avsm_CAPACITY + q;
        let bounds = avsm_joined(curve, q, c);
        let outer = vec2((*transmittances)[i - 1u], (*transmittances)[i + 1u]);
        cost = max(cost, avsm_spread(outer, bounds.y, bounds.x));
    }
    return cost;
}

// What it costs to leave out all nodes between two: the error on the stretch that this
// leaves.
fn avsm_stretch_cost(
    curve: ptr<function, avsm_Curve>,
    transmittances: ptr<function, array<f32, avsm_VALUES>>,
    first: u32,
    last: u32,
) -> f32 {
    var cost = 0.0;
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        let bounds = avsm_widened(curve, first, last, c);
        let row = c * avsm_CAPACITY;
        let outer = vec2((*transmittances)[row + first], (*transmittances)[row + last]);
        cost = max(cost, avsm_spread(outer, bounds.y, bounds.x));
    }
    return cost;
}

// The cost of two stretches together: the larger one.
fn avsm_both(a: f32, b: f32) -> f32 {
    return max(a, b);
}
