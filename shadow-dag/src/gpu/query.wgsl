// Queries of all kinds except rays: entry points, one invocation per query.

struct Parameters {
    dag: dag_Shadows,
    count: u32,
    // Texels per side of a filter's window.
    width: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> words: array<u32>;
@group(0) @binding(2) var<storage, read_write> results: array<u32>;
// What is asked about: each entry point uses one of these.
@group(0) @binding(3) var<storage> voxels: array<vec4<i32>>;
@group(0) @binding(3) var<storage> positions: array<vec4<f32>>;
@group(0) @binding(3) var<storage> texels: array<vec2<u32>>;

fn dag_word(index: u32) -> u32 {
    return words[index];
}

@compute @workgroup_size(64)
fn is_lit(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < parameters.count {
        results[i] = u32(dag_is_lit(parameters.dag, voxels[i].xyz));
    }
}

@compute @workgroup_size(64)
fn count_lit(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < parameters.count {
        results[i] = dag_count_lit(parameters.dag, voxels[i].xyz, parameters.width);
    }
}

@compute @workgroup_size(64)
fn filter_voxels(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < parameters.count {
        results[i] = bitcast<u32>(dag_filter(parameters.dag, voxels[i].xyz, parameters.width));
    }
}

@compute @workgroup_size(64)
fn filter_bilinear(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < parameters.count {
        let lit = dag_filter_bilinear(parameters.dag, positions[i].xyz, parameters.width);
        results[i] = bitcast<u32>(lit);
    }
}

@compute @workgroup_size(64)
fn depth(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < parameters.count {
        results[i] = dag_depth(parameters.dag, texels[i]);
    }
}

@compute @workgroup_size(64)
fn visibility(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < parameters.count {
        results[i] = dag_visibility(parameters.dag, voxels[2u * i].xyz, voxels[2u * i + 1u].xyz);
    }
}
