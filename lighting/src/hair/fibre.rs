//! How a strand scatters light.
//!
//! Based on: J. T. Kajiya, T. L. Kay, "Rendering fur with three dimensional textures",
//! SIGGRAPH 1989; S. R. Marschner, H. W. Jensen, M. Cammarano, S. Worley, P. Hanrahan,
//! "Light scattering from human hair fibers", SIGGRAPH 2003; E. d'Eon, G. Francois,
//! M. Hill, J. Letteri, J.-M. Aubry, "An energy-conserving hair reflectance model",
//! EGSR 2011, for the normalised longitudinal function. Departures: azimuthal functions are von
//! Mises lobes instead of integrals over the width of the fibre, attenuations are those of a
//! ray through its middle, and half of the light that passes a fibre is spread evenly, in place
//! of the light that other strands send back.

use std::f64::consts::PI;

use glam::Vec3;

/// How a strand scatters light.
///
/// Let `θ` be the inclination of a direction from the plane across the strand, positive towards
/// the tip, and `φ` the angle around the strand between two directions. Light from `(θ_i, φ_i)`
/// with the irradiance `E`, on a surface that faces it, gives the strand the radiance `L(θ_o,
/// φ_o)` over all of its width. In all directions together, the strand sends back the share
///
/// ```text
/// albedo(θ_i) = ∫ L cos θ_o dω_o / (E cos θ_i)
/// ```
///
/// of the light that meets it. The colour `C` is the share that a strand does not absorb.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Fibre {
    /// A diffuse cylinder with a highlight in the colour of the light, where `s` = 0.1 and `p`
    /// = 40:
    ///
    /// ```text
    /// L = E cos θ_i [ (1 − s) C / π² + s cos^p(θ_i + θ_o) / (2π J) ],   J = ∫ cos^(p+2)
    /// ```
    ///
    /// The integral runs from −π/2 to π/2, and the cosine of an angle above π/2 counts as 0.
    /// The albedo is `(1 − s) C + s` across the strand, and at most `(1 − s) C + s (cos² θ_i +
    /// sin² θ_i / (p + 1))` elsewhere.
    KajiyaKay,
    /// Light is reflected (R), transmitted (TT), or reflected inside the strand (TRT), each in
    /// a cone around the strand that its scales tilt:
    ///
    /// ```text
    /// L = E cos θ_i / cos θ_o Σ_p A_p M_p(θ_i, θ_o) N_p(φ) + E cos θ_i A_D / π²
    /// M_p = exp(−sin(θ_i − 2α_p) sin θ_o / v_p) I₀(cos(θ_i − 2α_p) cos θ_o / v_p) / (2 v_p sinh(1/v_p))
    ///
    /// p     A_p                    α_p      √v_p    N_p
    /// R     F                      −3.5°    0.15    cos(φ/2) / 4
    /// TT    (1 − F)² C / 2          1.75°   0.075   von Mises around π, κ = 12
    /// TRT   (1 − F)² F C²           5.25°   0.3     von Mises around 0, κ = 4
    /// D     (1 − F)² C / 2
    /// F = F₀ + (1 − F₀) (1 − cos θ_i)⁵,   F₀ = 0.0465 (η = 1.55)
    /// ```
    ///
    /// The albedo is `A_R + A_TT + A_TRT + A_D` at every angle. The papers have no term D. It
    /// stands for light that passes the strand and meets others: half of it is assumed to leave
    /// the hair, evenly in all directions.
    #[default]
    Marschner,
}

/// Share and exponent of the highlight of Kajiya and Kay's model.
const SPECULAR: f64 = 0.1;
const EXPONENT: i32 = 40;

/// Reflectance of keratin (η = 1.55) at normal incidence.
const REFLECTANCE: f64 = 0.0465;

/// The share of the light passing a strand that is spread evenly.
const SPREAD: f64 = 0.5;

/// A cone of light, with its tilt α in radians and its variance v.
struct Cone {
    tilt: f64,
    variance: f64,
}

const R: Cone = Cone {
    tilt: -0.0611,
    variance: 0.0225,
};
const TT: Cone = Cone {
    tilt: 0.0305,
    variance: 0.005625,
};
const TRT: Cone = Cone {
    tilt: 0.0916,
    variance: 0.09,
};

/// Concentrations of the von Mises lobes around the strand.
const TT_KAPPA: f64 = 12.0;
const TRT_KAPPA: f64 = 4.0;

impl Fibre {
    /// The radiance of a strand in the direction `to_eye`, for light from `to_light` with an
    /// irradiance of 1. `tangent` points towards the tip of the strand; all directions are unit
    /// vectors.
    ///
    /// It is 0 for light along the strand, and for an eye that looks along it.
    pub fn radiance(self, colour: Vec3, tangent: Vec3, to_light: Vec3, to_eye: Vec3) -> Vec3 {
        let [tangent, light, eye] = [tangent, to_light, to_eye].map(Vec3::as_dvec3);
        let (sin_i, sin_o) = (tangent.dot(light), tangent.dot(eye));
        let (across_i, across_o) = (light - sin_i * tangent, eye - sin_o * tangent);
        let (cos_i, cos_o) = (across_i.length(), across_o.length());
        // Next to the axis, angles around it are lost in rounding.
        if !(cos_i > AXIAL && cos_o > AXIAL) {
            return Vec3::ZERO;
        }
        if self == Self::KajiyaKay {
            let cos = (cos_i * cos_o - sin_i * sin_o).max(0.0);
            let highlight = SPECULAR * cos.powi(EXPONENT) / (2.0 * PI * cosine_integral());
            let diffuse = (1.0 - SPECULAR) / (PI * PI);
            let even = colour * (cos_i * diffuse) as f32;
            return even + Vec3::splat((cos_i * highlight) as f32);
        }
        let cos_phi = (across_i.dot(across_o) / (cos_i * cos_o)).clamp(-1.0, 1.0);
        let fresnel = fresnel(cos_i);
        let entered = (1.0 - fresnel) * (1.0 - fresnel);
        let foreshortened = cos_i / cos_o;
        let r = fresnel * R.around([sin_i, cos_i], [sin_o, cos_o]) * half_cosine(cos_phi);
        let tt = (1.0 - SPREAD)
            * entered
            * TT.around([sin_i, cos_i], [sin_o, cos_o])
            * von_mises(-cos_phi, TT_KAPPA);
        let trt = entered
            * fresnel
            * TRT.around([sin_i, cos_i], [sin_o, cos_o])
            * von_mises(cos_phi, TRT_KAPPA);
        let even = SPREAD * entered * cos_i / (PI * PI);
        Vec3::splat((foreshortened * r) as f32)
            + colour * (foreshortened * tt + even) as f32
            + colour * colour * (foreshortened * trt) as f32
    }

    /// The share of the light arriving at an inclination with this cosine that leaves the
    /// strand again; for [`Fibre::KajiyaKay`] an upper bound.
    pub fn albedo(self, colour: Vec3, cos_i: f32) -> Vec3 {
        if self == Self::KajiyaKay {
            let (cos2, specular) = (cos_i * cos_i, SPECULAR as f32);
            let highlight = cos2 + (1.0 - cos2) / (EXPONENT + 1) as f32;
            return (1.0 - specular) * colour + Vec3::splat(specular * highlight);
        }
        let fresnel = fresnel(cos_i.into()) as f32;
        let entered = (1.0 - fresnel) * (1.0 - fresnel);
        Vec3::splat(fresnel) + entered * (colour + fresnel * colour * colour)
    }
}

/// Cosines below this are lost in the rounding of unit vectors.
const AXIAL: f64 = 1e-6;

impl Cone {
    /// The longitudinal function, which is normalised to `∫ M cos θ_o dθ_o` = 1.
    fn around(&self, [sin_i, cos_i]: [f64; 2], [sin_o, cos_o]: [f64; 2]) -> f64 {
        let (sin, cos) = (2.0 * self.tilt).sin_cos();
        let (sin_i, cos_i) = (sin_i * cos - cos_i * sin, cos_i * cos + sin_i * sin);
        let v = self.variance;
        // The exponents are large and of different signs, so they are added first: 2 v
        // sinh(1/v) e^(−1/v) is v (1 − e^(−2/v)).
        let along = -sin_i * sin_o / v - 1.0 / v;
        let around = log_bessel((cos_i * cos_o / v).abs());
        (along + around).exp() / (v * -(-2.0 / v).exp_m1())
    }
}

/// Schlick's reflectance.
fn fresnel(cos: f64) -> f64 {
    REFLECTANCE + (1.0 - REFLECTANCE) * (1.0 - cos).powi(5)
}

/// `cos(φ/2)/4`, whose integral over φ is 1.
fn half_cosine(cos: f64) -> f64 {
    0.25 * (0.5 * (1.0 + cos)).sqrt()
}

/// The density of a von Mises distribution around 0.
fn von_mises(cos: f64, kappa: f64) -> f64 {
    (kappa * cos - log_bessel(kappa)).exp() / (2.0 * PI)
}

/// `ln I₀(x)` for `x ≥ 0`, to 1e-5.
fn log_bessel(x: f64) -> f64 {
    if x > 12.0 {
        // Hankel's asymptotic expansion.
        let y = 1.0 / (8.0 * x);
        return x - 0.5 * (2.0 * PI * x).ln() + (y + 4.5 * y * y + 37.5 * y * y * y).ln_1p();
    }
    // The power series, whose terms decrease from index x/2 on.
    let quarter = 0.25 * x * x;
    let (mut sum, mut term, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-7 * sum {
        term *= quarter / (k * k);
        sum += term;
        k += 1.0;
    }
    sum.ln()
}

/// `∫ cos^(p+2)` from −π/2 to π/2.
fn cosine_integral() -> f64 {
    // It is π (n − 1)!! / n!! for an even n.
    (1..=(EXPONENT + 2) / 2).fold(PI, |product, k| {
        let n = 2.0 * f64::from(k);
        product * (n - 1.0) / n
    })
}
