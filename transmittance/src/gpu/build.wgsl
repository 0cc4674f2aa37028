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
