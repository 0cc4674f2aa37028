// The squares of every candidate: an entry point.

struct BinParameters {
    width: u32,
    height: u32,
    candidates: u32,
}

@group(0) @binding(0) var<uniform> parameters: BinParameters;
// Four for each candidate; what is not a number of a square stands for none.
@group(0) @binding(1) var<storage, read_write> bins: array<u32>;

@compute @workgroup_size(64)
fn find_bins(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= parameters.candidates {
        return;
    }
    for (var k = 0u; k < avsm_MOST_BINS; k++) {
        bins[avsm_MOST_BINS * i + k] = 0xffffffffu;
    }
    let extent = vec2(parameters.width, parameters.height);
    let touched = avsm_candidate_texels(i);
    let end = min(touched.zw, extent);
    if any(touched.xy >= end) {
        return;
    }
    var side = avsm_TILE;
    var first = 0u;
    loop {
        let squares = avsm_bins(extent, side);
        let low = touched.xy / side;
        let size = (end - 1u) / side + 1u - low;
        if size.x * size.y <= avsm_MOST_BINS {
            for (var k = 0u; k < size.x * size.y; k++) {
                let at = low + vec2(k % size.x, k / size.x);
                bins[avsm_MOST_BINS * i + k] = first + at.y * squares.x + at.x;
            }
            return;
        }
        first += squares.x * squares.y;
        side *= 2u;
    }
}
