// Where the steps of a ray are: the shader's side of `Lattice`.

// Values of `placement`.
const light_steps_ANGLE: u32 = 0u;
const light_steps_LENGTH: u32 = 1u;

// See `lattice.rs`.
const light_steps_LEAST_STEP: f32 = 1e-6;
const light_steps_MOST_BEAMS: f32 = 4.0;
const light_steps_THROUGH: f32 = 1.001e-4;
const light_steps_AT_THE_LIGHT: f32 = 1.001e-12;

// Values of `kind`.
const light_lattice_EQUAL: u32 = 0u;
const light_lattice_TURNS: u32 = 1u;
const light_lattice_THROUGH: u32 = 2u;

struct light_Steps {
    axis: vec3<f32>,
    placement: u32,
    // Steps across the beam.
    count: f32,
    // The angle of a step at the light.
    turn: f32,
    // The length of a step along the beam, and how much more a length across the beam counts.
    length: f32,
    stretch: f32,
}

// Numbered positions along a ray.
struct light_Lattice {
    kind: u32,
    // For equal distances, the first position and the distance between two.
    from_here: f32,
    step: f32,
    // For equal angles, the direction from the light to the eye, in components towards the
    // foot point and along the ray, and the angle between two positions. A ray through the
    // light has a position at the light alone.
    eye: vec2<f32>,
    turn: f32,
}

// The steps of a ray that lie within `part`.
fn light_lattice(steps: light_Steps, path: light_Path, part: vec2<f32>) -> light_Lattice {
    var lattice: light_Lattice;
    let whole = part.y - part.x;
    if steps.placement == light_steps_ANGLE && light_emitter().kind == light_POINT {
        let eye = vec2(path.h, -path.foot);
        let d = length(eye);
        if path.h <= max(light_steps_THROUGH * d, light_steps_AT_THE_LIGHT) {
            lattice.kind = light_lattice_THROUGH;
            return lattice;
        }
        lattice.kind = light_lattice_TURNS;
        lattice.turn = steps.turn;
        lattice.eye = eye / d;
        return lattice;
    }
    lattice.from_here = part.x;
    // A step is not 0, or the positions would not advance.
    lattice.step = max(whole / steps.count, 1e-30);
    if steps.placement == light_steps_LENGTH {
        let aside = cross(path.direction, steps.axis);
        let step = steps.length / sqrt(1.0 + steps.stretch * dot(aside, aside));
        let least = max(
            light_steps_LEAST_STEP * part.y,
            whole / (light_steps_MOST_BEAMS * steps.count),
        );
        lattice.from_here = 0.0;
        lattice.step = max(max(step, least), 1e-30);
    }
    return lattice;
}

// The index of the last position that is not behind the distance x, to rounding.
fn light_lattice_number(lattice: light_Lattice, path: light_Path, x: f32) -> f32 {
    if lattice.kind == light_lattice_THROUGH {
        return select(0.0, 1.0, x >= path.foot);
    }
    if lattice.kind == light_lattice_TURNS {
        // This is the angle between the directions to the eye and to x, without a difference
        // of two angles.
        let across = path.h * x;
        let along = path.h * path.h - path.foot * (x - path.foot);
        return floor(light_angle(across, along) / lattice.turn);
    }
    return max(floor((x - lattice.from_here) / lattice.step), 0.0);
}

// The position with this index; light_FAR if there is none.
fn light_lattice_position(lattice: light_Lattice, path: light_Path, number: f32) -> f32 {
    if lattice.kind == light_lattice_THROUGH {
        return select(light_FAR, path.foot, number <= 1.0);
    }
    if lattice.kind == light_lattice_EQUAL {
        return lattice.from_here + number * lattice.step;
    }
    let angle = number * lattice.turn;
    if angle >= light_PI {
        return light_FAR;
    }
    // Cosine and sine of the angle.
    var turned = vec2(light_sin(abs(0.5 * light_PI - angle)), light_sin(min(angle, light_PI - angle)));
    turned.x = select(turned.x, -turned.x, angle > 0.5 * light_PI);
    let along = lattice.eye.y * turned.x + lattice.eye.x * turned.y;
    let towards = lattice.eye.x * turned.x - lattice.eye.y * turned.y;
    // Beyond this angle, rays of the light do not meet the ray from the eye.
    if towards <= 1e-12 {
        return light_FAR;
    }
    return path.foot + path.h * (along / towards);
}

// The middle of a step or of a part of it: half of its angle, or half of its length if it has
// no angle.
fn light_lattice_middle(lattice: light_Lattice, path: light_Path, start: f32, end: f32) -> f32 {
    if lattice.kind != light_lattice_TURNS {
        return clamp(0.5 * start + 0.5 * end, start, end);
    }
    let a = start - path.foot;
    let b = end - path.foot;
    let d_a = sqrt(a * a + path.h * path.h);
    let d_b = sqrt(b * b + path.h * path.h);
    let sum = d_a + d_b;
    // The bisector of two directions divides the ray in the ratio of their distances.
    return clamp(path.foot + (a * (d_b / sum) + b * (d_a / sum)), start, end);
}
