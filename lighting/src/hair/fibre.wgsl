// How a strand scatters light: the shader's side of `Fibre`, whose page has the equations.
//
// Needs the part numeric.wgsl. All directions are unit vectors, the tangent points towards the
// tip of the strand, and the light has an irradiance of 1.

const light_KAJIYA_KAY: u32 = 0u;
const light_MARSCHNER: u32 = 1u;

// Cosines below this are lost in the rounding of unit vectors.
const light_fibre_AXIAL: f32 = 1e-6;

// Kajiya and Kay's: (1 - s) / pi^2 and s / (2 pi J) for s = 0.1 and an exponent of 40.
const light_fibre_DIFFUSE: f32 = 0.091189065;
const light_fibre_HIGHLIGHT: f32 = 0.041394218;

// Reflectance of keratin at normal incidence, and the share of the light passing a strand that
// is spread evenly.
const light_fibre_REFLECTANCE: f32 = 0.0465;
const light_fibre_SPREAD: f32 = 0.5;

// Cones around the strand: tilt in radians, and variance.
const light_fibre_R: vec2<f32> = vec2(-0.0611, 0.0225);
const light_fibre_TT: vec2<f32> = vec2(0.0305, 0.005625);
const light_fibre_TRT: vec2<f32> = vec2(0.0916, 0.09);

// Concentrations of lobes around the strand, and ln I0 of them.
const light_fibre_TT_LOBE: vec2<f32> = vec2(12.0, 9.8495025);
const light_fibre_TRT_LOBE: vec2<f32> = vec2(4.0, 2.4249728);

// ln I0(x) for x >= 0.
fn light_fibre_log_bessel(x: f32) -> f32 {
    if x > 12.0 {
        // Hankel's asymptotic expansion.
        let y = 1.0 / (8.0 * x);
        return x - 0.5 * log(2.0 * light_PI * x) + log(1.0 + y * (1.0 + y * (4.5 + y * 37.5)));
    }
    // The power series, whose terms decrease from index x/2 on.
    let quarter = 0.25 * x * x;
    var sum = 1.0;
    var term = 1.0;
    var k = 1.0;
    while term > 1e-7 * sum {
        term *= quarter / (k * k);
        sum += term;
        k += 1.0;
    }
    return log(sum);
}

// The longitudinal function of a cone, for sines and cosines of the inclinations of light (xy)
// and eye (zw).
fn light_fibre_around(cone: vec2<f32>, inclinations: vec4<f32>) -> f32 {
    let sine = light_sin(abs(2.0 * cone.x)) * sign(cone.x);
    let cosine = sqrt((1.0 - sine) * (1.0 + sine));
    let sin_i = inclinations.x * cosine - inclinations.y * sine;
    let cos_i = inclinations.y * cosine + inclinations.x * sine;
    let v = cone.y;
    // The exponents are large and of different signs, so they are added first.
    let along = -(sin_i * inclinations.z + 1.0) / v;
    let around = light_fibre_log_bessel(abs(cos_i * inclinations.w / v));
    return exp(along + around) / (v * (1.0 - exp(-2.0 / v)));
}

// The density of a von Mises distribution around 0.
fn light_fibre_von_mises(lobe: vec2<f32>, cosine: f32) -> f32 {
    return exp(lobe.x * cosine - lobe.y) / (2.0 * light_PI);
}

fn light_fibre_radiance(
    fibre: u32,
    colour: vec3<f32>,
    tangent: vec3<f32>,
    to_light: vec3<f32>,
    to_eye: vec3<f32>,
) -> vec3<f32> {
    let sin_i = dot(tangent, to_light);
    let sin_o = dot(tangent, to_eye);
    let across_i = to_light - sin_i * tangent;
    let across_o = to_eye - sin_o * tangent;
    let cos_i = length(across_i);
    let cos_o = length(across_o);
    // Next to the axis, angles around it are lost in rounding.
    if !(cos_i > light_fibre_AXIAL && cos_o > light_fibre_AXIAL) {
        return vec3(0.0);
    }
    if fibre == light_KAJIYA_KAY {
        let cosine = max(cos_i * cos_o - sin_i * sin_o, 0.0);
        let square = cosine * cosine;
        let eighth = (square * square) * (square * square);
        let highlight = (eighth * eighth) * (eighth * eighth) * eighth;
        return cos_i * (light_fibre_DIFFUSE * colour + light_fibre_HIGHLIGHT * highlight);
    }
    let cos_phi = clamp(dot(across_i, across_o) / (cos_i * cos_o), -1.0, 1.0);
    let grazing = 1.0 - cos_i;
    let grazing2 = grazing * grazing;
    let fresnel = light_fibre_REFLECTANCE
        + (1.0 - light_fibre_REFLECTANCE) * (grazing2 * grazing2 * grazing);
    let entered = (1.0 - fresnel) * (1.0 - fresnel);
    let inclinations = vec4(sin_i, cos_i, sin_o, cos_o);
    let r = fresnel
        * light_fibre_around(light_fibre_R, inclinations)
        * (0.25 * sqrt(0.5 * (1.0 + cos_phi)));
    let tt = (1.0 - light_fibre_SPREAD) * entered
        * light_fibre_around(light_fibre_TT, inclinations)
        * light_fibre_von_mises(light_fibre_TT_LOBE, -cos_phi);
    let trt = entered * fresnel
        * light_fibre_around(light_fibre_TRT, inclinations)
        * light_fibre_von_mises(light_fibre_TRT_LOBE, cos_phi);
    let even = light_fibre_SPREAD * entered * cos_i / (light_PI * light_PI);
    let foreshortened = cos_i / cos_o;
    return vec3(foreshortened * r)
        + colour * (foreshortened * tt + even)
        + colour * colour * (foreshortened * trt);
}
