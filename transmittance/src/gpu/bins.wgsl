// Squares of texels of several sizes, in which candidates are looked for: of avsm_TILE texels
// a side, and on each further level of twice as many, up to one that holds the map. A
// candidate is in the smallest squares of which it touches no more than four.

const avsm_TILE: u32 = 16u;
const avsm_MOST_BINS: u32 = 4u;

// Columns and rows of squares.
fn avsm_bins(extent: vec2<u32>, side: u32) -> vec2<u32> {
    return (extent + side - 1u) / side;
}
