// The pieces of a line through media, from front to back: the shader's side of
// `MediaPieces`.
//
// Needs the parts MEDIA of `scene` and PATH, and the variables
//   light_media: light_Media
//   light_media_records: array<vec4<u32>>
//   light_media_densities: array<f32>
//   light_media_colours: array<f32>
// and the constant
//   light_media_MAX_GRIDS    the most grids, and the most phase functions
//
// Distances on a line are measured from where it enters the box around all grids and
// particles: there they have the digits that voxels far from the eye need. Those on a
// piece are measured from its start, for the digits that opaque smoke needs.

// All that fills the air; the record `MediaRecord`. The entries of light_media_records are,
// one kind after the other: grids (nine entries each), particles (two), kinds of particles
// (two), phase functions (two), boxes (two), the occupied cells of grids (a bit for each
// cell).
struct light_Media {
    even: light_Medium,
    height: scn_HeightFog,
    // The box around all grids and particles.
    low: vec3<f32>,
    grids: u32,
    high: vec3<f32>,
    balls: u32,
    first_ball: u32,
    first_kind: u32,
    first_phase: u32,
    phases: u32,
    first_box: u32,
    boxes: u32,
    // The numbers of the phase functions of both kinds of fog.
    even_phase: u32,
    height_phase: u32,
}

// Distances from here on count as infinite, and so do coefficients.
const light_media_END: f32 = 1e18;

// Stands for the place of colours that a grid does not have.
const light_media_NONE: u32 = 0xffffffffu;

fn scn_density(index: u32) -> f32 {
    return light_media_densities[index];
}

struct light_media_Grid {
    grid: scn_Grid,
    first_albedo: u32,
    first_emission: u32,
    phase: u32,
}

fn light_media_grid(index: u32) -> light_media_Grid {
    let at = 9u * index;
    let a = light_media_records[at];
    let b = light_media_records[at + 1u];
    let c = light_media_records[at + 2u];
    let d = light_media_records[at + 3u];
    var found: light_media_Grid;
    found.grid.row_x = bitcast<vec3<f32>>(a.xyz);
    found.grid.first = a.w;
    found.grid.row_y = bitcast<vec3<f32>>(b.xyz);
    found.grid.is_linear = b.w;
    found.grid.row_z = bitcast<vec3<f32>>(c.xyz);
    found.grid.scale = bitcast<f32>(c.w);
    found.grid.corner = bitcast<vec3<f32>>(d.xyz);
    found.grid.phase = d.w;
    found.grid.resolution = light_media_records[at + 4u].xyz;
    found.grid.tint = bitcast<vec3<f32>>(light_media_records[at + 5u].xyz);
    found.grid.albedo = bitcast<vec3<f32>>(light_media_records[at + 6u].xyz);
    found.grid.phase_parameters = bitcast<vec4<f32>>(light_media_records[at + 7u]);
    let own = light_media_records[at + 8u];
    found.first_albedo = own.x;
    found.first_emission = own.y;
    found.phase = own.z;
    return found;
}

struct light_media_Ball {
    centre: vec3<f32>,
    radius: f32,
    sigma_t: f32,
    kind: u32,
}

fn light_media_ball(index: u32) -> light_media_Ball {
    let at = light_media.first_ball + 2u * index;
    let place = bitcast<vec4<f32>>(light_media_records[at]);
    let other = light_media_records[at + 1u];
    return light_media_Ball(place.xyz, place.w, bitcast<f32>(other.x), other.y);
}

struct light_media_Kind {
    albedo: vec3<f32>,
    is_soft: bool,
    phase: u32,
}

fn light_media_kind(index: u32) -> light_media_Kind {
    let at = light_media.first_kind + 2u * index;
    let a = light_media_records[at];
    return light_media_Kind(
        bitcast<vec3<f32>>(a.xyz),
        a.w != 0u,
        light_media_records[at + 1u].x,
    );
}

// The part of a line in a box; empty unless x < y.
fn light_media_inside(
    low: vec3<f32>,
    high: vec3<f32>,
    origin: vec3<f32>,
    direction: vec3<f32>,
    part: vec2<f32>,
) -> vec2<f32> {
    let parallel = direction == vec3(0.0);
    let below = low - origin;
    let above = high - origin;
    if any(parallel & ((below > vec3(0.0)) | (above < vec3(0.0)))) {
        return vec2(0.0);
    }
    let slope = select(direction, vec3(1.0), parallel);
    let near = select(min(below / slope, above / slope), vec3(-scn_FAR), parallel);
    let far = select(max(below / slope, above / slope), vec3(scn_FAR), parallel);
    return vec2(
        max(max(part.x, near.x), max(near.y, near.z)),
        min(min(part.y, far.x), min(far.y, far.z)),
    );
}

// How many particles are kept sorted on a line.
const light_media_WINDOW: u32 = 16u;

struct light_MediaWalk {
    // The point from which distances are measured.
    origin: vec3<f32>,
    end: f32,
    direction: vec3<f32>,
    // The piece at hand.
    start: f32,
    stop: f32,
    // The part of the line in homogeneous fog.
    even: vec2<f32>,
    // The optical depth in front of the piece.
    depth: vec3<f32>,
    // The extinction on the piece without fog that thins out, 1/m, per colour: the Bernstein
    // coefficients of a cubic.
    sigma: mat4x3<f32>,
    is_empty: bool,
    // Whether there is smoke on it, of a grid or of particles.
    has_smoke: bool,
    // The cell of each grid, and the extinction there where the tint is 1, as a cubic.
    cells: array<scn_Walk, light_media_MAX_GRIDS>,
    cubics: array<vec4<f32>, light_media_MAX_GRIDS>,
    // The particles that end behind the start of the piece, by where they begin: those
    // that begin before `horizon`.
    window: array<u32, light_media_WINDOW>,
    chords: array<vec2<f32>, light_media_WINDOW>,
    count: u32,
    horizon: f32,
    // Whether the line is in more particles at once than the window has room for.
    is_full: bool,
}

// The walk along a ray up to the distance `end` from its origin, at most
// light_media_END. The ray's origin is at the distance −`base` of the walk, where
// `base = light_media_base(origin, direction, end)`:
//     var walk = light_media_walk(origin, direction, base, end);
//     while light_media_advance(&walk) { … }
fn light_media_walk(
    origin: vec3<f32>,
    direction: vec3<f32>,
    base: f32,
    end: f32,
) -> light_MediaWalk {
    var walk: light_MediaWalk;
    walk.origin = origin + base * direction;
    walk.direction = direction;
    walk.start = -base;
    walk.stop = -base;
    walk.end = select(end - base, light_media_END, end >= light_media_END);
    walk.even = vec2(light_media_END);
    if any(light_media.even.sigma_t > vec3(0.0)) {
        walk.even = vec2(walk.start, walk.end);
        if light_media.even.bounded != 0u {
            walk.even = light_media_inside(
                light_media.even.low,
                light_media.even.high,
                walk.origin,
                direction,
                walk.even,
            );
            if !(walk.even.x < walk.even.y) {
                walk.even = vec2(light_media_END);
            }
        }
    }
    for (var i = 0u; i < light_media.grids; i++) {
        let grid = light_media_grid(i).grid;
        var cells = scn_walk(grid, walk.origin, direction, walk.start, walk.end);
        light_media_next_cell(i, &cells);
        walk.cells[i] = cells;
    }
    if light_media.balls > 0u {
        // Nothing is known yet.
        walk.horizon = walk.start;
    } else {
        walk.horizon = light_media_END;
    }
    return walk;
}

// The distance along a ray from which distances of a walk are measured.
fn light_media_base(origin: vec3<f32>, direction: vec3<f32>, end: f32) -> f32 {
    if light_media.grids + light_media.balls == 0u {
        return 0.0;
    }
    let part = vec2(0.0, end);
    let inside = light_media_inside(light_media.low, light_media.high, origin, direction, part);
    return select(0.0, inside.x, inside.x < inside.y);
}

// Fills the window with those particles that end behind `start` and begin first.
fn light_media_look(walk: ptr<function, light_MediaWalk>, start: f32) {
    (*walk).count = 0u;
    (*walk).horizon = light_media_END;
    for (var i = 0u; i < light_media.balls; i++) {
        let ball = light_media_ball(i);
        let chord = scn_chord(ball.centre, ball.radius, (*walk).origin, (*walk).direction);
        let begin = chord.x - chord.y;
        if !(chord.y > 0.0) || !(chord.x + chord.y > start) || begin >= (*walk).end {
            continue;
        }
        if (*walk).count == light_media_WINDOW {
            let last = (*walk).chords[light_media_WINDOW - 1u];
            let dropped = max(begin, last.x - last.y);
            (*walk).horizon = min((*walk).horizon, dropped);
            if begin >= last.x - last.y {
                continue;
            }
        } else {
            (*walk).count += 1u;
        }
        var at = (*walk).count - 1u;
        while at > 0u {
            let before = (*walk).chords[at - 1u];
            if before.x - before.y <= begin {
                break;
            }
            (*walk).chords[at] = before;
            (*walk).window[at] = (*walk).window[at - 1u];
            at -= 1u;
        }
        (*walk).chords[at] = chord;
        (*walk).window[at] = i;
    }
    (*walk).is_full = (*walk).horizon <= start;
}

// A particle that may be on the piece, and where it is on the line.
struct light_media_Met {
    ball: light_media_Ball,
    chord: vec2<f32>,
}

// How many particles there may be on the piece; light_media_met numbers them.
fn light_media_met_count(walk: ptr<function, light_MediaWalk>) -> u32 {
    return select((*walk).count, light_media.balls, (*walk).is_full);
}

fn light_media_met(walk: ptr<function, light_MediaWalk>, number: u32) -> light_media_Met {
    var met: light_media_Met;
    if (*walk).is_full {
        met.ball = light_media_ball(number);
        let ball = met.ball;
        met.chord = scn_chord(ball.centre, ball.radius, (*walk).origin, (*walk).direction);
    } else {
        met.ball = light_media_ball((*walk).window[number]);
        met.chord = (*walk).chords[number];
    }
    return met;
}

// Whether the line is in a particle where the piece starts.
fn light_media_is_open(met: light_media_Met, start: f32) -> bool {
    let begin = met.chord.x - met.chord.y;
    return met.chord.y > 0.0 && begin <= start && start < met.chord.x + met.chord.y;
}

// Whether the line is in the cell where the piece starts.
fn light_media_is_in(cells: scn_Walk, start: f32) -> bool {
    return cells.far > cells.near && cells.base + cells.near <= start;
}

// Goes on to the next cell of a grid in which there is anything; `near` is not below `far`
// behind the last one.
fn light_media_next_cell(grid: u32, cells: ptr<function, scn_Walk>) {
    let first = light_media_records[9u * grid + 8u].w;
    let count = vec3<u32>((*cells).cells);
    while scn_next_cell(cells) {
        let cell = vec3<u32>((*cells).cell);
        let index = (cell.z * count.y + cell.y) * count.x + cell.x;
        let word = light_media_records[first + (index >> 7u)][(index >> 5u) & 3u];
        if ((word >> (index & 31u)) & 1u) != 0u {
            return;
        }
    }
}

// Goes on to the next piece; false at the end of the line.
fn light_media_advance(walk: ptr<function, light_MediaWalk>) -> bool {
    (*walk).depth += light_media_own_depth(walk, (*walk).stop - (*walk).start);
    let start = (*walk).stop;
    if !(start < (*walk).end) {
        return false;
    }
    (*walk).start = start;
    var stop = (*walk).end;
    var even = vec3(0.0);
    if (*walk).even.x > start {
        stop = min(stop, (*walk).even.x);
    } else if (*walk).even.y > start {
        stop = min(stop, (*walk).even.y);
        even = light_media.even.sigma_t;
    }
    for (var i = 0u; i < light_media.grids; i++) {
        var cells = (*walk).cells[i];
        var is_changed = false;
        while cells.far > cells.near && cells.base + cells.far <= start {
            light_media_next_cell(i, &cells);
            is_changed = true;
        }
        if is_changed {
            (*walk).cells[i] = cells;
        }
        if cells.far > cells.near {
            let begin = cells.base + cells.near;
            stop = min(stop, select(cells.base + cells.far, begin, begin > start));
        }
    }
    if light_media.balls > 0u {
        if (*walk).is_full || start >= (*walk).horizon {
            light_media_look(walk, start);
        }
        let count = light_media_met_count(walk);
        for (var i = 0u; i < count; i++) {
            let chord = light_media_met(walk, i).chord;
            let next = select(
                chord.x + chord.y,
                chord.x - chord.y,
                chord.x - chord.y > start,
            );
            if chord.y > 0.0 && next > start {
                stop = min(stop, next);
            }
        }
        if (*walk).horizon > start {
            stop = min(stop, (*walk).horizon);
        }
    }
    (*walk).stop = stop;
    // The end of the piece is known now; this finds what is on it.
    var sigma = mat4x3<f32>(even, even, even, even);
    var has_smoke = false;
    for (var i = 0u; i < light_media.grids; i++) {
        let cells = (*walk).cells[i];
        var cubic = vec4(0.0);
        if light_media_is_in(cells, start) {
            let grid = light_media_grid(i).grid;
            cubic = scn_cubic(grid, cells, start - cells.base, stop - cells.base);
            has_smoke = has_smoke || any(cubic != vec4(0.0));
            let tint = grid.tint;
            sigma += mat4x3<f32>(cubic.x * tint, cubic.y * tint, cubic.z * tint, cubic.w * tint);
        }
        (*walk).cubics[i] = cubic;
    }
    if light_media.balls > 0u {
        let count = light_media_met_count(walk);
        for (var i = 0u; i < count; i++) {
            let met = light_media_met(walk, i);
            if light_media_is_open(met, start) {
                has_smoke = true;
                let ball = met.ball;
                let is_soft = light_media_kind(ball.kind).is_soft;
                let cubic = scn_ball_cubic(
                    ball.sigma_t,
                    ball.radius,
                    is_soft,
                    met.chord,
                    start,
                    stop,
                );
                sigma += mat4x3<f32>(vec3(cubic.x), vec3(cubic.y), vec3(cubic.z), vec3(cubic.w));
            }
        }
    }
    (*walk).sigma = sigma;
    (*walk).has_smoke = has_smoke;
    let most = max(max(sigma[0], sigma[1]), max(sigma[2], sigma[3]));
    (*walk).is_empty = all(most == vec3(0.0)) && all(light_media.height.sigma_t == vec3(0.0));
    return true;
}

// A distance on the piece as a share of its length.
fn light_media_share(walk: ptr<function, light_MediaWalk>, length: f32) -> f32 {
    // Only homogeneous fog and fog that thins out are endless: sigma is constant there.
    if (*walk).stop >= light_media_END {
        return 0.0;
    }
    return clamp(length / ((*walk).stop - (*walk).start), 0.0, 1.0);
}

// The optical depth from the start of the piece to a distance on it.
fn light_media_own_depth(walk: ptr<function, light_MediaWalk>, length: f32) -> vec3<f32> {
    if !(length > 0.0) {
        return vec3(0.0);
    }
    let sigma = (*walk).sigma;
    let u = light_media_share(walk, length);
    let v = 1.0 - u;
    let first = sigma[0] * v + sigma[1] * u;
    let middle = sigma[1] * v + sigma[2] * u;
    let second = first * v + middle * u;
    let third = second * v + (middle * v + (sigma[2] * v + sigma[3] * u) * u) * u;
    let mean = 0.25 * ((sigma[0] + first) + (second + third));
    var depth = min(mean, vec3(light_media_END)) * min(length, light_media_END);
    let height = light_media.height;
    if any(height.sigma_t > vec3(0.0)) {
        let slope = (*walk).direction.y;
        let y = (*walk).origin.y + (*walk).start * slope;
        depth += height.sigma_t * min(scn_height_column(height, y, slope, length), light_media_END);
    }
    return depth;
}

// The extinction coefficient at a distance on the piece, 1/m.
fn light_media_extinction(walk: ptr<function, light_MediaWalk>, length: f32) -> vec3<f32> {
    let sigma = (*walk).sigma;
    let u = light_media_share(walk, length);
    let v = 1.0 - u;
    let middle = sigma[1] * v + sigma[2] * u;
    let second = (sigma[0] * v + sigma[1] * u) * v + middle * u;
    var extinction = second * v + (middle * v + (sigma[2] * v + sigma[3] * u) * u) * u;
    let height = light_media.height;
    if any(height.sigma_t > vec3(0.0)) {
        let y = (*walk).origin.y + ((*walk).start + length) * (*walk).direction.y;
        extinction += height.sigma_t * min(scn_height_density(height, y), light_media_END);
    }
    return extinction;
}

// The colour of a grid's samples at a distance on the line, which lies in the cell at hand;
// `first` is the place of the grid's first colour.
fn light_media_colour(
    walk: ptr<function, light_MediaWalk>,
    grid: scn_Grid,
    index: u32,
    first: u32,
    x: f32,
) -> vec3<f32> {
    let cells = (*walk).cells[index];
    let cell = vec3<u32>(cells.cell);
    let own = cells.start - vec3<f32>(cells.cell);
    let place = clamp(own + (x - cells.base) * cells.direction, vec3(0.0), vec3(1.0));
    if grid.is_linear == 0u {
        return light_media_colour_at(grid, cell, first);
    }
    let near = light_media_colour_between(grid, cell, first, place.xy);
    let far = light_media_colour_between(grid, cell + vec3(0u, 0u, 1u), first, place.xy);
    return near * (1.0 - place.z) + far * place.z;
}

// The colour between the four samples on one side of a cell.
fn light_media_colour_between(
    grid: scn_Grid,
    cell: vec3<u32>,
    first: u32,
    place: vec2<f32>,
) -> vec3<f32> {
    let a = light_media_colour_at(grid, cell, first) * (1.0 - place.x)
        + light_media_colour_at(grid, cell + vec3(1u, 0u, 0u), first) * place.x;
    let b = light_media_colour_at(grid, cell + vec3(0u, 1u, 0u), first) * (1.0 - place.x)
        + light_media_colour_at(grid, cell + vec3(1u, 1u, 0u), first) * place.x;
    return a * (1.0 - place.y) + b * place.y;
}

fn light_media_colour_at(grid: scn_Grid, sample: vec3<u32>, first: u32) -> vec3<f32> {
    let at = min(sample, grid.resolution - 1u);
    let index = (at.z * grid.resolution.y + at.y) * grid.resolution.x + at.x;
    let place = first + 3u * index;
    return vec3(
        light_media_colours[place],
        light_media_colours[place + 1u],
        light_media_colours[place + 2u],
    );
}

// e^−x for x ≥ 0.
fn light_media_exp(x: vec3<f32>) -> vec3<f32> {
    return exp(-min(x, vec3(80.0)));
}

// 1 − e^−x for x ≥ 0, with the digits of a small result.
fn light_media_taken(x: vec3<f32>) -> vec3<f32> {
    let y = min(x, vec3(80.0));
    return y * vec3(
        light_mean_exponential(y.x),
        light_mean_exponential(y.y),
        light_mean_exponential(y.z),
    );
}
