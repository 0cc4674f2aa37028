// Columns of fog that thins out with altitude. Lengths are in metres; scn_FAR stands for
// infinity.

const scn_FAR: f32 = 3.40282347e38;

// Fog that thins out with altitude; the record `HeightFogRecord`.
struct scn_HeightFog {
    // Coefficients at `altitude`, 1/m.
    sigma_s: vec3<f32>,
    altitude: f32,
    sigma_t: vec3<f32>,
    scale_height: f32,
    phase_parameters: vec4<f32>,
    phase: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// The factor on its coefficients at the height y.
fn scn_height_density(fog: scn_HeightFog, y: f32) -> f32 {
    return exp(clamp((fog.altitude - y) / fog.scale_height, -scn_STEEP, scn_STEEP));
}

// The largest exponent of e. Fog more scale heights than this below its altitude gets no
// denser.
const scn_STEEP: f32 = 80.0;

// The length of a horizontal path at the fog's own altitude that has the same optical depth
// as a path of the length `length`, which may be scn_FAR, that begins at the height y and
// rises by `slope` per metre. At most scn_FAR.
fn scn_height_column(fog: scn_HeightFog, y: f32, slope: f32, length: f32) -> f32 {
    let rate = abs(slope) / fog.scale_height;
    let fall = min(length, 1e30) * rate;
    // (1 − e^−fall) / fall, by its series where digits would cancel.
    var share = 1.0;
    if fall < 0.5 {
        share = 1.0 - fall / 2.0 * (1.0 - fall / 3.0 * (1.0 - fall / 4.0 * (1.0
            - fall / 5.0 * (1.0 - fall / 6.0 * (1.0 - fall / 7.0 * (1.0 - fall / 8.0))))));
    } else {
        share = (1.0 - exp(-min(fall, scn_STEEP))) / fall;
    }
    // Measured from the lower end upwards, so that the exponential falls.
    let low = select(y, y + slope * min(length, 1e30), slope < 0.0);
    let density = scn_height_density(fog, low);
    if fall >= 0.5 {
        return min(density * (share * fall), scn_FAR * min(rate, 1.0)) / max(rate, 1e-37);
    }
    return min(min(density * share, scn_FAR / max(length, 1.0)) * length, scn_FAR);
}
