// Makes the curves of a map: entry point, one invocation per texel. A dispatch
// takes a part of each texel's segments; curves that are not finished wait in a
// buffer.

struct Parameters {
    // Of the map.
    width: u32,
    // Texels of this dispatch, and the first of them.
    texels: u32,
    first_texel: u32,
    // Segments of this dispatch.
    first: u32,
    end: u32,
    is_last: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read_write> words: array<u32>;
@group(0) @binding(2) var<storage, read_write> unfinished: array<u32>;

fn avsm_word(index: u32) -> u32 {
    return words[index];
}

fn avsm_set_word(index: u32, word: u32) {
    words[index] = word;
}

// Where number `k` of an unfinished curve is: neighbours of neighbours.
fn place(i: u32, k: u32) -> u32 {
    return k * parameters.texels + i;
}

fn resume(i: u32) -> avsm_Curve {
    var curve: avsm_Curve;
    curve.len = unfinished[place(i, 0u)];
    curve.insertions = unfinished[place(i, 1u)];
    for (var k = 0u; k < avsm_ROOM; k++) {
        curve.depth[k] = bitcast<f32>(unfinished[place(i, 2u + k)]);
    }
    for (var k = 0u; k < avsm_PLACES; k++) {
        let at = 2u + avsm_ROOM + k;
        curve.value[k] = bitcast<f32>(unfinished[place(i, at)]);
        curve.above[k] = bitcast<f32>(unfinished[place(i, at + avsm_PLACES)]);
        curve.below[k] = bitcast<f32>(unfinished[place(i, at + 2u * avsm_PLACES)]);
    }
    return curve;
}

fn suspend(i: u32, curve: ptr<function, avsm_Curve>) {
    unfinished[place(i, 0u)] = (*curve).len;
    unfinished[place(i, 1u)] = (*curve).insertions;
    for (var k = 0u; k < avsm_ROOM; k++) {
        unfinished[place(i, 2u + k)] = bitcast<u32>((*curve).depth[k]);
    }
    for (var k = 0u; k < avsm_PLACES; k++) {
        let at = 2u + avsm_ROOM + k;
        unfinished[place(i, at)] = bitcast<u32>((*curve).value[k]);
        unfinished[place(i, at + avsm_PLACES)] = bitcast<u32>((*curve).above[k]);
        unfinished[place(i, at + 2u * avsm_PLACES)] = bitcast<u32>((*curve).below[k]);
    }
}

@compute @workgroup_size(64)
fn build(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= parameters.texels {
        return;
    }
    let number = parameters.first_texel + i;
    let texel = vec2(number % parameters.width, number / parameters.width);
    var curve: avsm_Curve;
    if parameters.first > 0u {
        curve = resume(i);
    }
    let count = avsm_segment_count(texel);
    for (var s = parameters.first; s < min(count, parameters.end); s++) {
        avsm_insert(&curve, avsm_segment(texel, s));
    }
    if parameters.is_last == 0u {
        suspend(i, &curve);
        return;
    }
    if count > parameters.end {
        // Some are missing: no bound but 1.
        curve.insertions = 0xffffffffu;
    }
    avsm_finish(&curve);
    avsm_store(number, &curve);
}
