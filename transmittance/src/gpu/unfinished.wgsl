// Curves that wait between the dispatches that make them. Needs the variable `parameters`,
// whose member `texels` is the number of curves.

@group(0) @binding(1) var<storage, read_write> words: array<u32>;
@group(0) @binding(2) var<storage, read_write> unfinished: array<u32>;

fn avsm_word(index: u32) -> u32 {
    return words[index];
}

fn avsm_set_word(index: u32, word: u32) {
    words[index] = word;
}

// Where word `k` of an unfinished curve is: next to that of the neighbouring texel, so
// that invocations side by side read words side by side.
fn place(i: u32, k: u32) -> u32 {
    return k * parameters.texels + i;
}

fn resume(i: u32) -> avsm_Curve {
    var curve: avsm_Curve;
    curve.len = unfinished[place(i, 0u)];
    curve.insertions = unfinished[place(i, 1u)];
    for (var k = 0u; k < avsm_CAPACITY; k++) {
        curve.depth[k] = bitcast<f32>(unfinished[place(i, 2u + k)]);
    }
    for (var k = 0u; k < avsm_VALUES; k++) {
        let at = 2u + avsm_CAPACITY + k;
        curve.value[k] = bitcast<f32>(unfinished[place(i, at)]);
        curve.above[k] = bitcast<f32>(unfinished[place(i, at + avsm_VALUES)]);
        curve.below[k] = bitcast<f32>(unfinished[place(i, at + 2u * avsm_VALUES)]);
    }
    return curve;
}

fn suspend(i: u32, curve: ptr<function, avsm_Curve>) {
    unfinished[place(i, 0u)] = (*curve).len;
    unfinished[place(i, 1u)] = (*curve).insertions;
    for (var k = 0u; k < avsm_CAPACITY; k++) {
        unfinished[place(i, 2u + k)] = bitcast<u32>((*curve).depth[k]);
    }
    for (var k = 0u; k < avsm_VALUES; k++) {
        let at = 2u + avsm_CAPACITY + k;
        unfinished[place(i, at)] = bitcast<u32>((*curve).value[k]);
        unfinished[place(i, at + avsm_VALUES)] = bitcast<u32>((*curve).above[k]);
        unfinished[place(i, at + 2u * avsm_VALUES)] = bitcast<u32>((*curve).below[k]);
    }
}
