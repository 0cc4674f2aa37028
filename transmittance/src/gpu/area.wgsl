// What it costs to remove the node between two others: the area between the
// curves before and after, as `Area`.
fn avsm_cost(
    curve: ptr<function, avsm_Curve>,
    transmittances: ptr<function, array<f32, avsm_PLACES>>,
    q: u32,
) -> f32 {
    let depth = 0.25 * vec3((*curve).depth[q - 1u], (*curve).depth[q], (*curve).depth[q + 1u]);
    let widths = depth.yz - depth.xy;
    var cost = 0.0;
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        let i = c * avsm_ROOM + q;
        let values = vec3((*curve).value[i - 1u], (*curve).value[i], (*curve).value[i + 1u]);
        let around = vec3((*transmittances)[i - 1u], (*transmittances)[i], (*transmittances)[i + 1u]);
        cost += avsm_area(widths, values, around);
    }
    return cost;
}
