// Makes the curves of a map: entry points, one invocation per texel. A dispatch
// takes a part of each texel's segments; curves that are not finished wait in a
// buffer for the next dispatch.

struct Parameters {
    // Texels of a row of the map.
    width: u32,
    // The number of texels of this dispatch, and the first of them.
    texels: u32,
    first_texel: u32,
    // The segments of each texel that this dispatch takes: from `first` to before `end`.
    first: u32,
    end: u32,
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

fn texel_of(i: u32) -> vec2<u32> {
    let number = parameters.first_texel + i;
    return vec2(number % parameters.width, number / parameters.width);
}

fn insert_segments(i: u32, curve: ptr<function, avsm_Curve>) {
    let texel = texel_of(i);
    let end = min(avsm_segment_count(texel), parameters.end);
    for (var s = parameters.first; s < end; s++) {
        avsm_insert(curve, avsm_segment(texel, s));
    }
}

fn finish_and_store(i: u32, curve: ptr<function, avsm_Curve>) {
    if avsm_segment_count(texel_of(i)) > parameters.end {
        // Segments are missing, so that no bound below 1 holds.
        (*curve).insertions = avsm_INCOMPLETE;
    }
    avsm_finish(curve);
    avsm_store(parameters.first_texel + i, curve);
}

// Makes a whole curve, or what is left of one, and stores it.
@compute @workgroup_size(64)
fn complete(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= parameters.texels {
        return;
    }
    var curve: avsm_Curve;
    if parameters.first > 0u {
        curve = resume(i);
    }
    insert_segments(i, &curve);
    finish_and_store(i, &curve);
}

// Inserts a part of the segments and suspends the curve.
@compute @workgroup_size(64)
fn insert(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= parameters.texels {
        return;
    }
    var curve: avsm_Curve;
    if parameters.first > 0u {
        curve = resume(i);
    }
    insert_segments(i, &curve);
    suspend(i, &curve);
}

// Finishes and stores a curve that was suspended.
@compute @workgroup_size(64)
fn finish(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= parameters.texels {
        return;
    }
    var curve = resume(i);
    finish_and_store(i, &curve);
}
