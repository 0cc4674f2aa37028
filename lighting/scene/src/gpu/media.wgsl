// Optical depths of density grids and of balls, along lines `origin + t direction` with a unit
// vector as direction. Lengths are in metres.
//
// Needs the part height_fog.wgsl, which says what stands for infinity, and
//   fn scn_density(index: u32) -> f32    the densities of all grids

// A density grid; the record `GridRecord`.
struct scn_Grid {
    // Rows of the matrix that takes world offsets from the corner to cells.
    row_x: vec3<f32>,
    // The index of its first density.
    first: u32,
    row_y: vec3<f32>,
    // 1 for trilinear between samples, 0 for voxels.
    is_linear: u32,
    row_z: vec3<f32>,
    // The extinction coefficient of a density of 1, 1/m.
    scale: f32,
    corner: vec3<f32>,
    phase: u32,
    resolution: vec3<u32>,
    padding_a: u32,
    tint: vec3<f32>,
    padding_b: u32,
    albedo: vec3<f32>,
    padding_c: u32,
    phase_parameters: vec4<f32>,
}

// The cells of a grid along a line. From the first call of scn_next_cell on, `cell`
// is the cell that the line runs through from the distance base + near to
// base + far.
struct scn_Walk {
    // Where the line enters the grid, and its direction per metre, in cells.
    start: vec3<f32>,
    base: f32,
    direction: vec3<f32>,
    // Where the line leaves the grid; like `near` and `far` a distance from `base`.
    end: f32,
    cells: vec3<i32>,
    near: f32,
    cell: vec3<i32>,
    far: f32,
    next: vec3<i32>,
}

// The number of cells along each axis: voxels, or the spaces between samples.
fn scn_cells(grid: scn_Grid) -> vec3<u32> {
    let between = max(grid.resolution, vec3(2u)) - 1u;
    return select(grid.resolution, between, grid.is_linear != 0u);
}

// A world offset in units of cells.
fn scn_in_cells(grid: scn_Grid, offset: vec3<f32>) -> vec3<f32> {
    return vec3(dot(grid.row_x, offset), dot(grid.row_y, offset), dot(grid.row_z, offset));
}

// A line that moves by less than this along an axis, in cells per metre, never gets from one
// cell to another there.
const scn_STILL: f32 = 1e-30;

// The walk for t from `near` to `far`, which may be scn_FAR:
//     var walk = scn_walk(grid, origin, direction, near, far);
//     while scn_next_cell(&walk) {
//         depth += (walk.far - walk.near) * scn_mean(scn_cubic(grid, walk, walk.near, walk.far));
//     }
fn scn_walk(
    grid: scn_Grid,
    origin: vec3<f32>,
    direction: vec3<f32>,
    near: f32,
    far: f32,
) -> scn_Walk {
    var walk = scn_Walk();
    let cells = scn_cells(grid);
    let start = scn_in_cells(grid, origin - grid.corner);
    walk.direction = scn_in_cells(grid, direction);
    walk.cells = vec3<i32>(cells);
    var enter = near;
    var leave = far;
    for (var axis = 0; axis < 3; axis++) {
        let step = walk.direction[axis];
        let size = f32(cells[axis]);
        if abs(step) < scn_STILL {
            if !(start[axis] >= 0.0 && start[axis] <= size) {
                leave = enter;
            }
        } else {
            let a = -start[axis] / step;
            let b = (size - start[axis]) / step;
            enter = max(enter, min(a, b));
            leave = min(leave, max(a, b));
        }
    }
    walk.base = enter;
    if enter < leave {
        walk.end = leave - enter;
    }
    walk.start = start + enter * walk.direction;
    walk.next = clamp(vec3<i32>(walk.start), vec3(0), walk.cells - 1);
    return walk;
}

// Goes on to the next cell; false behind the last one.
fn scn_next_cell(walk: ptr<function, scn_Walk>) -> bool {
    (*walk).near = (*walk).far;
    // A cell is left through one of three faces, never to come back.
    while (*walk).far < (*walk).end {
        let step = (*walk).direction;
        let still = abs(step) < vec3(scn_STILL);
        let face = vec3<f32>((*walk).next) + select(vec3(0.0), vec3(1.0), step > vec3(0.0));
        let leaving = select(
            (face - (*walk).start) / select(step, vec3(1.0), still),
            vec3(scn_FAR),
            still,
        );
        (*walk).cell = (*walk).next;
        let first = min(leaving.x, min(leaving.y, leaving.z));
        var axis = 2;
        if leaving.x == first {
            axis = 0;
        } else if leaving.y == first {
            axis = 1;
        }
        (*walk).next[axis] += select(-1, 1, step[axis] > 0.0);
        let is_inside = (*walk).next[axis] >= 0 && (*walk).next[axis] < (*walk).cells[axis];
        // What rounding leaves of the line behind the last cell belongs to that cell.
        (*walk).far = select((*walk).end, clamp(first, (*walk).near, (*walk).end), is_inside);
        if (*walk).far > (*walk).near {
            return true;
        }
    }
    return false;
}

// The density at a corner of a cell.
fn scn_sample(grid: scn_Grid, cell: vec3<u32>, corner: vec3<u32>) -> f32 {
    let at = min(cell + corner, grid.resolution - 1u);
    return scn_density(grid.first + (at.z * grid.resolution.y + at.y) * grid.resolution.x + at.x);
}

// The extinction coefficient, 1/m, along the part from `near` to `far` (measured from base)
// of the walk's cell, where the tint is 1: the Bernstein coefficients of a cubic over u from
// 0 to 1. None is negative.
fn scn_cubic(grid: scn_Grid, walk: scn_Walk, near: f32, far: f32) -> vec4<f32> {
    let cell = vec3<u32>(walk.cell);
    if grid.is_linear == 0u {
        return vec4(grid.scale * scn_sample(grid, cell, vec3(0u)));
    }
    let origin = walk.start - vec3<f32>(walk.cell);
    let a = clamp(origin + near * walk.direction, vec3(0.0), vec3(1.0));
    let b = clamp(origin + far * walk.direction, vec3(0.0), vec3(1.0));
    // Four rows along x, each at both ends of the part.
    let low = vec4(
        scn_sample(grid, cell, vec3(0u, 0u, 0u)),
        scn_sample(grid, cell, vec3(0u, 1u, 0u)),
        scn_sample(grid, cell, vec3(0u, 0u, 1u)),
        scn_sample(grid, cell, vec3(0u, 1u, 1u)),
    );
    let high = vec4(
        scn_sample(grid, cell, vec3(1u, 0u, 0u)),
        scn_sample(grid, cell, vec3(1u, 1u, 0u)),
        scn_sample(grid, cell, vec3(1u, 0u, 1u)),
        scn_sample(grid, cell, vec3(1u, 1u, 1u)),
    );
    let rows_a = low * (1.0 - a.x) + high * a.x;
    let rows_b = low * (1.0 - b.x) + high * b.x;
    // Two slices along y; the letters tell at which end of the part x and y are.
    let aa = rows_a.xz * (1.0 - a.y) + rows_a.yw * a.y;
    let ab = rows_a.xz * (1.0 - b.y) + rows_a.yw * b.y;
    let ba = rows_b.xz * (1.0 - a.y) + rows_b.yw * a.y;
    let bb = rows_b.xz * (1.0 - b.y) + rows_b.yw * b.y;
    let za = vec2(1.0 - a.z, a.z);
    let zb = vec2(1.0 - b.z, b.z);
    let third = 1.0 / 3.0;
    return grid.scale * vec4(
        dot(aa, za),
        third * (dot(ba, za) + dot(ab, za) + dot(aa, zb)),
        third * (dot(bb, za) + dot(ba, zb) + dot(ab, zb)),
        dot(bb, zb),
    );
}

// The mean of a cubic over u from 0 to 1.
fn scn_mean(cubic: vec4<f32>) -> f32 {
    return 0.25 * ((cubic.x + cubic.y) + (cubic.z + cubic.w));
}

// The same polynomial with 0 to u as its domain: its last coefficient is the value at u, and
// u times its mean is the integral up to u.
fn scn_up_to(cubic: vec4<f32>, u: f32) -> vec4<f32> {
    let first = cubic.xyz * (1.0 - u) + cubic.yzw * u;
    let second = first.xy * (1.0 - u) + first.yz * u;
    return vec4(cubic.x, first.x, second.x, second.x * (1.0 - u) + second.y * u);
}

// The optical depth of a grid for t from `near` to `far`, where the tint is 1.
fn scn_grid_depth(
    grid: scn_Grid,
    origin: vec3<f32>,
    direction: vec3<f32>,
    near: f32,
    far: f32,
) -> f32 {
    var depth = 0.0;
    var walk = scn_walk(grid, origin, direction, near, far);
    while scn_next_cell(&walk) {
        depth += (walk.far - walk.near) * scn_mean(scn_cubic(grid, walk, walk.near, walk.far));
    }
    return depth;
}

// The chord of a ball: the distance of its middle, and half its length, 0 if the line
// misses the ball.
fn scn_chord(
    centre: vec3<f32>,
    radius: f32,
    origin: vec3<f32>,
    direction: vec3<f32>,
) -> vec2<f32> {
    let offset = centre - origin;
    let aside = cross(direction, offset);
    let half_squared = radius * radius - dot(aside, aside);
    return vec2(dot(offset, direction), sqrt(max(half_squared, 0.0)));
}

// The extinction of a ball between two distances within its chord, as a cubic over u
// from 0 to 1: constant, or falling as 1 − r²/R².
fn scn_ball_cubic(
    sigma_t: f32,
    radius: f32,
    is_soft: bool,
    chord: vec2<f32>,
    near: f32,
    far: f32,
) -> vec4<f32> {
    if !is_soft {
        return vec4(sigma_t);
    }
    let a = near - chord.x;
    let b = far - chord.x;
    let square = chord.y * chord.y;
    let quadratic = max(square - vec3(a * a, a * b, b * b), vec3(0.0))
        * (sigma_t / (radius * radius));
    return vec4(
        quadratic.x,
        (quadratic.x + 2.0 * quadratic.y) / 3.0,
        (2.0 * quadratic.y + quadratic.z) / 3.0,
        quadratic.z,
    );
}
