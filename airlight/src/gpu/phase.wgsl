// Phase functions, from 1 − cos θ and 1 + cos θ, which keep the digits of
// sharp peaks. The kinds are those of `PhaseRecord`.

const air_ISOTROPIC: u32 = 0u;
const air_HENYEY_GREENSTEIN: u32 = 1u;
const air_RAYLEIGH: u32 = 2u;
const air_SCHLICK: u32 = 3u;
const air_CORNETTE_SHANKS: u32 = 4u;
const air_DOUBLE_HENYEY_GREENSTEIN: u32 = 5u;
const air_HENYEY_GREENSTEIN_DRAINE: u32 = 6u;

const air_PI: f32 = 3.14159274;

// The phase function p, in 1/sr. `PhaseRecord` says what the parameters are.
fn air_phase(kind: u32, parameters: vec4<f32>, one_minus_cos: f32, one_plus_cos: f32) -> f32 {
    let g = abs(parameters.x);
    let away = select(one_plus_cos, one_minus_cos, parameters.x >= 0.0);
    let cos = 0.5 * (one_plus_cos - one_minus_cos);
    switch kind {
        case air_HENYEY_GREENSTEIN: {
            return 0.25 / air_PI * air_peak(g, away);
        }
        case air_RAYLEIGH: {
            return 3.0 / (16.0 * air_PI) * (1.0 + cos * cos);
        }
        case air_SCHLICK: {
            let distance = (1.0 - g) + g * away;
            return 0.25 / air_PI * ((1.0 - g) * (1.0 + g)) / (distance * distance);
        }
        case air_CORNETTE_SHANKS: {
            let rayleigh = (1.0 + cos * cos) / (2.0 + g * g);
            return 3.0 / (8.0 * air_PI) * rayleigh * air_peak(g, away);
        }
        case air_DOUBLE_HENYEY_GREENSTEIN, air_HENYEY_GREENSTEIN_DRAINE: {
            let other = parameters.y;
            let other_away = select(one_plus_cos, one_minus_cos, other >= 0.0);
            let first = air_peak(g, away);
            let second = air_peak(abs(other), other_away);
            if kind == air_DOUBLE_HENYEY_GREENSTEIN {
                let weight = parameters.z;
                return 0.25 / air_PI * (weight * first + (1.0 - weight) * second);
            }
            let alpha = parameters.z;
            let norm = 1.0 + alpha * (1.0 + 2.0 * other * other) / 3.0;
            let draine = (1.0 + alpha * cos * cos) / norm * second;
            return 0.25 / air_PI * ((1.0 - parameters.w) * first + parameters.w * draine);
        }
        default: {
            return 0.25 / air_PI;
        }
    }
}

// (1 − g²) / (1 + g² − 2 g cos θ)^{3/2} for g ≥ 0 and away = 1 − cos θ.
fn air_peak(g: f32, away: f32) -> f32 {
    let distance2 = (1.0 - g) * (1.0 - g) + 2.0 * g * away;
    return ((1.0 - g) * (1.0 + g)) / (distance2 * sqrt(distance2));
}

// The phase function at the position s of a ray, 0 at the foot point of the light and
// positive behind it; the ray passes the light at the distance h. Undefined at the light
// itself, s = h = 0.
fn air_phase_from_foot(kind: u32, parameters: vec4<f32>, s: f32, h: f32) -> f32 {
    let d = sqrt(s * s + h * h);
    let large = 1.0 + abs(s) / d;
    let small = (h / d) * (h / d) / large;
    return air_phase(
        kind,
        parameters,
        select(large, small, s < 0.0),
        select(small, large, s < 0.0),
    );
}
