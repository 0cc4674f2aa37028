// Density grids as candidates: which cell of a grid a ray meets, found by its number alone.
//
// The planes between cells cut a ray at three evenly spaced series of distances, one for each
// axis. The cell with number n is behind n of these planes in all. How many of each axis those
// are follows from the place where coordinates add up to n, but for one plane and roundings.
//
// Needs the part MEDIA of `scene`, candidates.wgsl, and the variables
//   light_grids: array<light_GridRays>
//   light_densities: array<f32>

struct light_GridRays {
    grid: scn_Grid,
    // In cells from the corner of the grid: a point of the ray of the first texel.
    start: vec3<f32>,
    // Depth of that point; of central rays, how far it is in front of the light.
    reach: f32,
    // The direction of that ray, which leads one metre forwards, in cells.
    direction: vec3<f32>,
    // Of the colour channel that the texels belong to.
    tint: f32,
    // What a column adds to `start`, or to the direction of central rays.
    across: vec3<f32>,
    // As many as a ray has cells, at most.
    segments: u32,
    // What a row adds.
    down: vec3<f32>,
    padding: u32,
}

// Planes by which the first guess of a cell may be off: one, and three that rounding puts on
// the other side.
const light_GUESS: i32 = 4;
// Steps from there to the cell.
const light_STEPS: u32 = 10u;

fn scn_density(index: u32) -> f32 {
    return light_densities[index];
}

fn light_least(v: vec3<f32>) -> f32 {
    return min(v.x, min(v.y, v.z));
}

fn light_greatest(v: vec3<f32>) -> f32 {
    return max(v.x, max(v.y, v.z));
}

// The first axis along which a vector has this coordinate, as a unit vector.
fn light_axis_of(v: vec3<f32>, value: f32) -> vec3<i32> {
    if v.x == value {
        return vec3(1, 0, 0);
    }
    if v.y == value {
        return vec3(0, 1, 0);
    }
    return vec3(0, 0, 1);
}

// Entry, exit and optical depth of what a cell of a grid takes from a texel's ray.
fn light_grid_met(
    it: light_GridRays,
    offset: vec2<f32>,
    texel: vec2<u32>,
    index: u32,
) -> vec3<f32> {
    // Distances along the ray count from `start`, which is at this depth.
    var depth = it.reach;
    var enter = -scn_FAR;
    let aside = offset.x * it.across + offset.y * it.down;
    var start = it.start + aside;
    var direction = it.direction;
    if light_picture.parallel == 0u {
        let ray_length = length(light_central_ray(texel));
        depth = it.reach * ray_length;
        // What is behind the origin casts no shadow.
        enter = -depth;
        start = it.start + it.reach * aside;
        direction = (it.direction + aside) / ray_length;
    }
    let cells = vec3<f32>(scn_cells(it.grid));
    let still = abs(direction) < vec3(scn_STILL);
    if any(still & ((start < vec3(0.0)) | (start > cells))) {
        return vec3(0.0);
    }
    // Cells are counted along the ray.
    let slope = select(direction, vec3(1.0), still);
    let is_upwards = slope > vec3(0.0);
    let low = -start / slope;
    let high = (cells - start) / slope;
    enter = max(enter, light_greatest(select(min(low, high), vec3(-scn_FAR), still)));
    let leave = light_least(select(max(low, high), vec3(scn_FAR), still));
    if !(enter < leave) {
        return vec3(0.0);
    }
    let last_cell = vec3<i32>(cells) - 1;
    let here = select(cells - start, start, is_upwards);
    let speed = select(abs(direction), vec3(0.0), still);
    // Where the cells of all axes add up to the number, if each coordinate is in the middle of
    // its cell.
    let cell_here = clamp(floor(here), vec3(0.0), cells - 1.0);
    let behind_planes = select(here - 0.5, cell_here, still);
    let guess = (f32(index) - dot(behind_planes, vec3(1.0))) / dot(speed, vec3(1.0));
    let at_guess = here + clamp(guess, enter, leave) * speed;
    var cell = clamp(vec3<i32>(floor(at_guess)), vec3(0), last_cell);
    let number = i32(index);
    for (var step = 0u; step < light_STEPS; step++) {
        let planes = vec3<f32>(cell);
        let entered = select(cells - planes, planes, is_upwards);
        let left = select(entered - 1.0, entered + 1.0, is_upwards);
        // The planes that the ray has crossed last and crosses next on each axis: the faces of
        // the grid are none of them.
        let crossed = select(
            (entered - start) / slope,
            vec3(-scn_FAR),
            still | (cell == vec3(0)),
        );
        let ahead = select((left - start) / slope, vec3(scn_FAR), still | (cell == last_cell));
        let last = light_greatest(crossed);
        let next = light_least(ahead);
        let too_many = cell.x + cell.y + cell.z - number;
        if abs(too_many) > light_GUESS {
            // The ray is outside of the grid where it would be in this cell.
            break;
        }
        if too_many == 0 && last <= next {
            let near = max(enter, last);
            let far = min(leave, next);
            if !(near < far) {
                break;
            }
            var walk: scn_Walk;
            walk.start = start;
            walk.direction = direction;
            walk.cell = select(last_cell - cell, cell, is_upwards);
            let mean = scn_mean(scn_cubic(it.grid, walk, near, far));
            return vec3(depth + near, depth + far, it.tint * mean * (far - near));
        }
        // Steps back or on, unless there is no such plane.
        if too_many > 0 {
            if last == -scn_FAR {
                break;
            }
            cell -= light_axis_of(crossed, last);
        } else {
            if next == scn_FAR {
                break;
            }
            cell += light_axis_of(ahead, next);
        }
    }
    return vec3(0.0);
}
