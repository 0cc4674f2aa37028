// The voxels along φ.
//
// Needs
//   fn epi_bound(index: u32) -> vec2<f32>    the φ between voxels index − 1 and index,
//                                            for index from 0 to l.bits

// The position of a φ, from 0 to the number of bits: its whole part is the voxel.
fn epi_phi_position(l: epi_Lattice, phi: vec2<f32>) -> f32 {
    var first = 0u;
    var count = l.bits;
    while count > 1u {
        let half = count / 2u;
        if epi_cross(epi_bound(first + half), phi) >= 0.0 {
            first += half;
        }
        count -= half;
    }
    let passed = max(epi_cross(epi_bound(first), phi), 0.0);
    let left = max(epi_cross(phi, epi_bound(first + 1u)), 0.0);
    let sum = passed + left;
    // Both are 0 only if the bounds coincide.
    var share = 0.5;
    if sum > 0.0 {
        share = passed / sum;
    }
    return f32(first) + share;
}

// The φ at a position; outside of 0 to the number of bits, that of the nearer end.
fn epi_phi_at(l: epi_Lattice, position: f32) -> vec2<f32> {
    let inside = clamp(position, 0.0, f32(l.bits));
    let first = min(u32(inside), l.bits - 1u);
    let bound = epi_bound(first);
    return bound + (inside - f32(first)) * (epi_bound(first + 1u) - bound);
}
