// Where the steps of a ray are: the shader's side of `Lattice`.

// Values of `placement`.
const light_steps_ANGLE: u32 = 0u;
const light_steps_LENGTH: u32 = 1u;

// See `lattice.rs`.
const light_steps_LEAST_STEP: f32 = 1e-6;
const light_steps_MOST_BEAMS: f32 = 4.0;

struct light_Steps {
    axis: vec3<f32>,
    placement: u32,
    // Across the beam.
    count: f32,
    // The angle of one at the light.
    turn: f32,
    // Length of the beam over their number, and how much more one across it counts.
    length: f32,
    stretch: f32,
}

// Numbered positions along a ray.
struct light_Lattice {
    is_turning: bool,
    // At equal distances.
    from_here: f32,
    step: f32,
    // At equal angles: the direction from the light to the eye, along that to the foot
    // point and along the ray.
    eye: vec2<f32>,
    turn: f32,
}

// The steps of a ray, of which those within `part` are wanted.
fn light_lattice(steps: light_Steps, path: light_Path, part: vec2<f32>) -> light_Lattice {
    var lattice: light_Lattice;
    let length = part.y - part.x;
    if steps.placement == light_steps_ANGLE && light_emitter().kind == light_POINT {
        lattice.is_turning = true;
        lattice.turn = steps.turn;
        let eye = vec2(path.h, -path.foot);
        let d = sqrt(dot(eye, eye));
        // At the light itself there is no angle: any will do.
        lattice.eye = select(vec2(0.0, 1.0), eye / max(d, 1e-30), d > 0.0);
        return lattice;
    }
    lattice.from_here = part.x;
    lattice.step = length / steps.count;
    if steps.placement == light_steps_LENGTH {
        let aside = cross(path.direction, steps.axis);
        let step = steps.length / sqrt(1.0 + steps.stretch * dot(aside, aside));
        let least = max(
            light_steps_LEAST_STEP * part.y,
            length / (light_steps_MOST_BEAMS * steps.count),
        );
        lattice.from_here = 0.0;
        lattice.step = max(step, least);
    }
    return lattice;
}

// The number of the last position that is not behind the distance x, to rounding.
fn light_lattice_number(lattice: light_Lattice, path: light_Path, x: f32) -> f32 {
    if lattice.is_turning {
        // The angle between the directions to the eye and to x, without a difference of
        // the two.
        let across = path.h * x;
        let along = path.h * path.h - path.foot * (x - path.foot);
        return floor(light_angle(across, along) / lattice.turn);
    }
    return max(floor((x - lattice.from_here) / lattice.step), 0.0);
}

// A position; light_FAR if there is none.
fn light_lattice_position(lattice: light_Lattice, path: light_Path, number: f32) -> f32 {
    if !lattice.is_turning {
        return lattice.from_here + number * lattice.step;
    }
    let angle = number * lattice.turn;
    if angle >= light_PI {
        return light_FAR;
    }
    // Cosine and sine.
    var turned = vec2(light_sin(abs(0.5 * light_PI - angle)), light_sin(min(angle, light_PI - angle)));
    turned.x = select(turned.x, -turned.x, angle > 0.5 * light_PI);
    let along = lattice.eye.y * turned.x + lattice.eye.x * turned.y;
    let towards = lattice.eye.x * turned.x - lattice.eye.y * turned.y;
    // Rays of the light that do not come down to the line of the eye's.
    if towards <= 1e-12 {
        return light_FAR;
    }
    return path.foot + path.h * (along / towards);
}

// The middle of a step or of a part of it: half of its angle or of its length.
fn light_lattice_middle(lattice: light_Lattice, path: light_Path, start: f32, end: f32) -> f32 {
    if !lattice.is_turning {
        return clamp(0.5 * start + 0.5 * end, start, end);
    }
    let a = start - path.foot;
    let b = end - path.foot;
    let d_a = sqrt(a * a + path.h * path.h);
    let d_b = sqrt(b * b + path.h * path.h);
    let sum = d_a + d_b;
    // Two ends at the light are one.
    if !(sum > 0.0) {
        return start;
    }
    // The bisector of two directions meets the ray by the ratio of distances.
    return clamp(path.foot + (a * (d_b / sum) + b * (d_a / sum)), start, end);
}
