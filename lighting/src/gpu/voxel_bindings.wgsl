// Where the voxels of a light are found when this crate assembles the shader.

struct Voxels {
    lattice: epi_Lattice,
    sampling: vsv_Sampling,
    detail: u32,
    state: u32,
}

@group(1) @binding(0) var<uniform> voxels: Voxels;
@group(1) @binding(1) var<storage> bounds: array<vec2<f32>>;
@group(1) @binding(2) var<storage> words: array<u32>;

fn epi_bound(index: u32) -> vec2<f32> {
    return bounds[index];
}

fn vsv_word(index: u32) -> u32 {
    return words[index];
}

fn light_voxel_lattice() -> epi_Lattice {
    return voxels.lattice;
}

fn light_voxel_sampling() -> vsv_Sampling {
    return voxels.sampling;
}

fn light_voxel_detail() -> u32 {
    return voxels.detail;
}

fn light_voxel_state() -> u32 {
    return voxels.state;
}
