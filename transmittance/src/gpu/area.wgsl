// What it costs to remove the inner node q: the area between the curves before and after,
// as `Area` measures it. Depths are scaled by 1/4, so that their differences are finite.
fn avsm_cost(
    curve: ptr<function, avsm_Curve>,
    transmittances: ptr<function, array<f32, avsm_VALUES>>,
    q: u32,
) -> f32 {
    let depth = 0.25 * vec3((*curve).depth[q - 1u], (*curve).depth[q], (*curve).depth[q + 1u]);
    let widths = depth.yz - depth.xy;
    var cost = 0.0;
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        let i = c * avsm_CAPACITY + q;
        let values = vec3((*curve).value[i - 1u], (*curve).value[i], (*curve).value[i + 1u]);
        let around = vec3((*transmittances)[i - 1u], (*transmittances)[i], (*transmittances)[i + 1u]);
        cost += avsm_area(widths, values, around);
    }
    return cost;
}

// What it costs to leave out all nodes between two: the area between the curves, as a sum
// over the nodes that are left out, each weighted with half of the way between its
// neighbours.
fn avsm_stretch_cost(
    curve: ptr<function, avsm_Curve>,
    transmittances: ptr<function, array<f32, avsm_VALUES>>,
    first: u32,
    last: u32,
) -> f32 {
    let start = 0.25 * (*curve).depth[first];
    let length = max(0.25 * (*curve).depth[last] - start, 0x1p-126);
    var cost = 0.0;
    for (var x = first + 1u; x < last; x++) {
        let share = 0.125 * (*curve).depth[x + 1u] - 0.125 * (*curve).depth[x - 1u];
        let way = min((0.25 * (*curve).depth[x] - start) / length, 1.0);
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            let row = c * avsm_CAPACITY;
            let value = (*curve).value[row + first];
            let chord = value + ((*curve).value[row + last] - value) * way;
            cost += share * abs((*transmittances)[row + x] - avsm_transmittance(chord));
        }
    }
    return cost;
}

// The cost of two stretches together: areas add up.
fn avsm_both(a: f32, b: f32) -> f32 {
    return a + b;
}
