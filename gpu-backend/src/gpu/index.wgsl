// The number of an invocation in a dispatch with one invocation for each item of an array:
// `workgroup` is workgroup_id, `workgroups` num_workgroups, `local`
// local_invocation_index, `size` the number of invocations per workgroup. The last
// invocations may have numbers beyond the items and must do nothing.
fn gpu_index(workgroup: vec3<u32>, workgroups: vec3<u32>, local: u32, size: u32) -> u32 {
    return (workgroup.y * workgroups.x + workgroup.x) * size + local;
}
