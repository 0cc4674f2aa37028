// Keeps the best subset of a curve's nodes, by dynamic programming, as `Stream`
// on the CPU:
//   best(s, j) = min over i < j of best(s - 1, i) + cost(i, j)
// with avsm_both in place of the sum.
// Needs the constant avsm_CHOICE, from how many nodes to choose, and the part
// curve.wgsl.

const avsm_TABLE: u32 = avsm_NODES * avsm_CAPACITY;

// Chooses avsm_NODES nodes of up to avsm_CHOICE.
fn avsm_finish(curve: ptr<function, avsm_Curve>) {
    avsm_reduce(curve, avsm_CHOICE);
    let len = (*curve).len;
    if len <= avsm_NODES {
        return;
    }
    var transmittances: array<f32, avsm_VALUES>;
    for (var i = 0u; i < avsm_VALUES; i++) {
        transmittances[i] = avsm_transmittance((*curve).value[i]);
    }
    // At s avsm_CAPACITY + j: the least cost of a curve from the first node to node j with s
    // nodes between, and the last of those.
    var best: array<f32, avsm_TABLE>;
    var before: array<u32, avsm_TABLE>;
    for (var i = 0u; i < avsm_TABLE; i++) {
        best[i] = avsm_LARGEST;
    }
    // So many nodes are left out, perhaps all of them in one stretch.
    let left_out = len - avsm_NODES;
    for (var i = 0u; i + 1u < len; i++) {
        let end = min(len, i + left_out + 2u);
        // The places in the chosen curve that node i can have.
        let first_place = max(max(i, left_out) - left_out, u32(i > 0u));
        for (var j = i + 1u; j < end; j++) {
            let cost = avsm_stretch_cost(curve, &transmittances, i, j);
            for (var place = first_place; place < min(i + 1u, avsm_NODES - 1u); place++) {
                var so_far = 0.0;
                if place > 0u {
                    so_far = best[(place - 1u) * avsm_CAPACITY + i];
                }
                let sum = avsm_both(so_far, cost);
                if sum < best[place * avsm_CAPACITY + j] {
                    best[place * avsm_CAPACITY + j] = sum;
                    before[place * avsm_CAPACITY + j] = i;
                }
            }
        }
    }
    var chosen: array<u32, avsm_NODES>;
    chosen[avsm_NODES - 1u] = len - 1u;
    for (var place = avsm_NODES - 2u; place > 0u; place--) {
        let next = chosen[place + 1u];
        chosen[place] = clamp(before[place * avsm_CAPACITY + next], place, next - 1u);
    }
    for (var place = 0u; place < avsm_NODES; place++) {
        let i = chosen[place];
        (*curve).depth[place] = (*curve).depth[i];
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            let row = c * avsm_CAPACITY;
            var bounds = vec2(0.0);
            if place + 1u < avsm_NODES {
                bounds = avsm_widened(curve, i, chosen[place + 1u], c);
            }
            (*curve).value[row + place] = (*curve).value[row + i];
            (*curve).above[row + place] = bounds.x;
            (*curve).below[row + place] = bounds.y;
        }
    }
    (*curve).len = avsm_NODES;
}
