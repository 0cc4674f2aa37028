// A transmittance curve in the memory of an invocation: blockers are put in, and
// nodes removed where the capacity is used up, with a bound of the error.
//
// Based on: M. Salvi, K. Vidimce, A. Lauritzen, A. Lefohn, "Adaptive Volumetric
// Shadow Maps", Eurographics Symposium on Rendering 2010. The steps are those of
// `Curve` and `Stream` on the CPU; where a GPU rounds more, the bounds are wider.
//
// Loops run over the whole capacity whatever the number of nodes, and elements are
// chosen by conditions on the index, so that a compiler that unrolls them can
// keep the curve in registers.
//
// Needs the constants avsm_NODES, avsm_CAPACITY, avsm_CHANNELS and avsm_VALUES =
// avsm_CAPACITY avsm_CHANNELS, the parts segment.wgsl and numeric.wgsl, one of
// exponential.wgsl and linear.wgsl with its rules of insertion, and one of area.wgsl and
// maximum.wgsl.

// In the bound of roundings, an insertion on a GPU counts as this many on the CPU. A
// node that is made is within 9 u (avsm_mix), what it gets from a blocker within 9 u (a
// share, a product, a sum), and the factor of a linear curve within another 5 u: at most
// 23 u, where the CPU counts 2 u for optical depths and 4 u for transmittances.
const avsm_ROUNDINGS: u32 = 12u;

// Nodes from front to back, as on the CPU; entries from `len` on are not used.
// Channel c of node i is at avsm_CAPACITY c + i.
struct avsm_Curve {
    len: u32,
    // Insertions so far, as the bound of roundings counts them.
    insertions: u32,
    depth: array<f32, avsm_CAPACITY>,
    // The value of a node, and how far the exact one may lie above and below the curve on
    // the stretch behind it.
    value: array<f32, avsm_VALUES>,
    above: array<f32, avsm_VALUES>,
    below: array<f32, avsm_VALUES>,
}

// The number of nodes in front of a depth.
fn avsm_count_in_front(curve: ptr<function, avsm_Curve>, depth: f32) -> u32 {
    var count = 0u;
    for (var i = 0u; i < avsm_CAPACITY; i++) {
        count += u32(i < (*curve).len && (*curve).depth[i] < depth);
    }
    return count;
}

fn avsm_has_node(curve: ptr<function, avsm_Curve>, index: u32, depth: f32) -> bool {
    return index < (*curve).len && (*curve).depth[index] == depth;
}

// Makes room in front of node `index` by moving it and those behind it one place on. The
// node is then there twice.
fn avsm_open(curve: ptr<function, avsm_Curve>, index: u32) {
    for (var i = avsm_CAPACITY - 1u; i > 0u; i--) {
        if i <= index {
            continue;
        }
        (*curve).depth[i] = (*curve).depth[i - 1u];
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            let place = c * avsm_CAPACITY + i;
            (*curve).value[place] = (*curve).value[place - 1u];
            (*curve).above[place] = (*curve).above[place - 1u];
            (*curve).below[place] = (*curve).below[place - 1u];
        }
    }
    (*curve).len += 1u;
}

// Makes a node at a depth on the curve, to be node `index`.
fn avsm_make_node(curve: ptr<function, avsm_Curve>, index: u32, depth: f32) {
    avsm_open(curve, index);
    (*curve).depth[index] = depth;
    let is_last = index + 1u == (*curve).len;
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        let i = c * avsm_CAPACITY + index;
        if index == 0u {
            (*curve).value[i] = avsm_CLEAR;
            (*curve).above[i] = 0.0;
            (*curve).below[i] = 0.0;
            continue;
        }
        var value = (*curve).value[i - 1u];
        if !is_last {
            let ends = vec2((*curve).depth[index - 1u], (*curve).depth[index + 1u]);
            value = avsm_mix(vec2(value, (*curve).value[i + 1u]), avsm_shares(ends, depth));
        }
        (*curve).value[i] = value;
        (*curve).above[i] = (*curve).above[i - 1u];
        (*curve).below[i] = (*curve).below[i - 1u];
    }
}

// How far a value lies above another and below it, both cut off at avsm_DARK, and what
// their roundings can add, each being within 30 u.
fn avsm_cut_difference(value: f32, chord: f32) -> vec2<f32> {
    if min(value, chord) > 1.0001 * avsm_DARK {
        return vec2(0.0);
    }
    let cut = min(vec2(value, chord), vec2(avsm_DARK));
    return vec2(cut.x - cut.y, cut.y - cut.x) + 3e-6 * max(cut.x, cut.y);
}

// Where a stretch reaches the dark, as a share of its length; 0 if it does not.
fn avsm_cut(values: vec2<f32>) -> f32 {
    if values.x < avsm_DARK && avsm_DARK < values.y {
        return (avsm_DARK - values.x) / (values.y - values.x);
    }
    return 0.0;
}

// The most by which the stretch between two depths lies above a chord that reaches the
// dark, and the most by which it lies below; the latter only where depths can be asked,
// from the first one behind the chord's start on. See `joined.rs`.
fn avsm_moved(
    depths: vec2<f32>,
    values: vec2<f32>,
    ends: vec2<f32>,
    end_values: vec2<f32>,
) -> vec2<f32> {
    if !(depths.x < depths.y) {
        return vec2(0.0);
    }
    let chord = vec2(
        avsm_mix(end_values, avsm_shares(ends, depths.x)),
        avsm_mix(end_values, avsm_shares(ends, depths.y)),
    );
    // Next to 0 a CPU may ask at depths that a device does not tell from it.
    var first_asked = 0.0;
    if depths.x == ends.x && abs(ends.x) > 0x1p-100 {
        first_asked = avsm_shares(depths, min(avsm_next_up(ends.x), depths.y)).y;
    }
    var shares = vec4(0.0, 1.0, avsm_cut(values), avsm_cut(chord));
    var moved = vec2(0.0);
    for (var k = 0u; k < 4u; k++) {
        let above = vec2(1.0 - shares[k], shares[k]);
        let later = max(shares[k], first_asked);
        let below = vec2(1.0 - later, later);
        let lies = vec2(
            avsm_cut_difference(avsm_mix(values, above), avsm_mix(chord, above)).x,
            avsm_cut_difference(avsm_mix(values, below), avsm_mix(chord, below)).y,
        );
        moved = max(moved, lies);
    }
    return moved;
}

// The bounds above and below of the stretch that is left when inner node q goes.
fn avsm_joined(curve: ptr<function, avsm_Curve>, q: u32, channel: u32) -> vec2<f32> {
    let ends = vec2((*curve).depth[q - 1u], (*curve).depth[q + 1u]);
    let depth = (*curve).depth[q];
    let i = channel * avsm_CAPACITY + q;
    let values = vec2((*curve).value[i - 1u], (*curve).value[i + 1u]);
    let value = (*curve).value[i];
    let front = vec2((*curve).above[i - 1u], (*curve).below[i - 1u]);
    let back = vec2((*curve).above[i], (*curve).below[i]);
    if values.y > avsm_DARK {
        let in_front = avsm_moved(vec2(ends.x, depth), vec2(values.x, value), ends, values);
        let behind = avsm_moved(vec2(depth, ends.y), vec2(value, values.y), ends, values);
        return max(front + in_front, back + behind) * 1.0000004;
    }
    let chord = avsm_mix(values, avsm_shares(ends, depth));
    let height = value - chord;
    // The chord is within 9 u, the difference within another.
    let slack = 8e-7 * max(value, chord);
    let tent = vec2(max(height, 0.0), max(-height, 0.0)) + slack;
    return (max(front, back) + tent) * 1.0000004;
}

// The bounds of the stretch from node `first` to node `last` that leaves out
// those between.
fn avsm_widened(curve: ptr<function, avsm_Curve>, first: u32, last: u32, channel: u32) -> vec2<f32> {
    let row = channel * avsm_CAPACITY;
    let ends = vec2((*curve).depth[first], (*curve).depth[last]);
    let values = vec2((*curve).value[row + first], (*curve).value[row + last]);
    var bounds = vec2(0.0);
    // Heights over the chord, and what their roundings are relative to.
    var left = vec2(0.0);
    for (var i = first; i < last; i++) {
        let stretch = vec2((*curve).above[row + i], (*curve).below[row + i]);
        if values.y > avsm_DARK {
            let depths = vec2((*curve).depth[i], (*curve).depth[i + 1u]);
            let between = vec2((*curve).value[row + i], (*curve).value[row + i + 1u]);
            let moved = avsm_moved(depths, between, ends, values);
            bounds = max(bounds, (stretch + moved) * 1.0000004);
            continue;
        }
        var right = vec2(0.0);
        if i + 1u < last {
            let value = (*curve).value[row + i + 1u];
            let chord = avsm_mix(values, avsm_shares(ends, (*curve).depth[i + 1u]));
            right = vec2(value - chord, max(value, chord));
        }
        let tent = vec2(max(left.x, right.x), max(-left.x, -right.x));
        let slack = vec2(8e-7 * max(left.y, right.y));
        bounds = max(bounds, (stretch + max(tent, vec2(0.0)) + slack) * 1.0000004);
        left = right;
    }
    return bounds;
}

// The key by which the cheapest node is found: its cost in the high bits, so that integers
// compare as costs do, and its number in the low ones. Nodes that cannot be removed have
// the largest key.
fn avsm_key(
    curve: ptr<function, avsm_Curve>,
    transmittances: ptr<function, array<f32, avsm_VALUES>>,
    q: u32,
) -> i32 {
    if q == 0u || q + 1u >= (*curve).len {
        return 0x7fffffff;
    }
    let cost = max(avsm_cost(curve, transmittances, q), 0.0);
    return (bitcast<i32>(cost) & ~0xff) | i32(q);
}

// Removes inner nodes, the cheapest first, until at most `keep` >= 2 are left.
fn avsm_reduce(curve: ptr<function, avsm_Curve>, keep: u32) {
    if (*curve).len <= keep {
        return;
    }
    var transmittances: array<f32, avsm_VALUES>;
    for (var i = 0u; i < avsm_VALUES; i++) {
        transmittances[i] = avsm_transmittance((*curve).value[i]);
    }
    var keys: array<i32, avsm_CAPACITY>;
    for (var q = 0u; q < avsm_CAPACITY; q++) {
        keys[q] = avsm_key(curve, &transmittances, q);
    }
    while (*curve).len > keep {
        var least = 0x7fffffff;
        for (var i = 0u; i < avsm_CAPACITY; i++) {
            least = min(least, keys[i]);
        }
        let q = clamp(u32(least) & 0xffu, 1u, avsm_CAPACITY - 2u);
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            let bounds = avsm_joined(curve, q, c);
            (*curve).above[c * avsm_CAPACITY + q - 1u] = bounds.x;
            (*curve).below[c * avsm_CAPACITY + q - 1u] = bounds.y;
        }
        for (var i = 1u; i < avsm_CAPACITY; i++) {
            if i <= q {
                continue;
            }
            (*curve).depth[i - 1u] = (*curve).depth[i];
            keys[i - 1u] = select(keys[i] - 1, keys[i], keys[i] == 0x7fffffff);
            for (var c = 0u; c < avsm_CHANNELS; c++) {
                let place = c * avsm_CAPACITY + i;
                (*curve).value[place - 1u] = (*curve).value[place];
                (*curve).above[place - 1u] = (*curve).above[place];
                (*curve).below[place - 1u] = (*curve).below[place];
                transmittances[place - 1u] = transmittances[place];
            }
        }
        (*curve).len -= 1u;
        keys[q - 1u] = avsm_key(curve, &transmittances, q - 1u);
        keys[q] = avsm_key(curve, &transmittances, q);
        keys[avsm_CAPACITY - 1u] = 0x7fffffff;
    }
}

// The segment as it is inserted: an opaque one has no length, numbers below 2^-126 are 0,
// and what is no segment (NaN, an exit in front of the entry, a negative optical depth)
// takes no light.
fn avsm_checked(segment: avsm_Segment) -> avsm_Segment {
    var checked = segment;
    var is_segment = avsm_is_finite(segment.entry) && avsm_is_finite(segment.exit);
    checked.entry = avsm_normal(segment.entry);
    checked.exit = avsm_normal(segment.exit);
    is_segment = is_segment && checked.entry <= checked.exit;
    var is_opaque = false;
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        let tau = segment.optical_depth[c];
        let bits = bitcast<u32>(tau);
        // Infinity is a number here, -0 is not below 0.
        is_segment = is_segment && (bits <= 0x7f800000u || bits == 0x80000000u);
        is_opaque = is_opaque || bits >= bitcast<u32>(1e30);
        checked.optical_depth[c] = min(avsm_normal(tau), 1e30);
        if bits == 0x7f800000u {
            checked.optical_depth[c] = 1e30;
        }
    }
    if !is_segment {
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            checked.optical_depth[c] = 0.0;
        }
    }
    if is_opaque {
        checked.exit = checked.entry;
    }
    return checked;
}

// A clear ray.
fn avsm_clear() -> avsm_Curve {
    return avsm_Curve();
}

// Adds a blocker. One that is clear or no segment at all changes nothing.
fn avsm_insert(curve: ptr<function, avsm_Curve>, blocker: avsm_Segment) {
    let segment = avsm_checked(blocker);
    var most = 0.0;
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        most = max(most, segment.optical_depth[c]);
    }
    if most <= 0.0 {
        return;
    }
    // Makes room for the two nodes of an insertion.
    avsm_reduce(curve, avsm_CAPACITY - 2u);
    (*curve).insertions += min(avsm_ROUNDINGS, 0xffffffffu - (*curve).insertions);
    // The number of the node at the entry, which is made if there is none. Two nodes at
    // the same depth are a step.
    var first = avsm_count_in_front(curve, segment.entry);
    let is_there = avsm_has_node(curve, first, segment.entry);
    let is_step = is_there && avsm_has_node(curve, first + 1u, segment.entry);
    if !is_there {
        avsm_make_node(curve, first, segment.entry);
    }
    // The first node that gets all of the optical depth: the one at the exit, which is made
    // if there is none.
    var after = first + 1u;
    if segment.entry < segment.exit {
        first += u32(is_step);
        after = avsm_count_in_front(curve, segment.exit);
        if !avsm_has_node(curve, after, segment.exit) {
            avsm_make_node(curve, after, segment.exit);
        }
    } else if !is_step {
        avsm_open(curve, first);
    }
    avsm_attenuate(curve, first, after, segment);
}
