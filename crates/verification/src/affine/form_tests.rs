//! Whether each operation on Taylor models encloses, and whether its radius is no larger than it has to be.

use pulp::Scalar;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{AXES, Form, PAIRS, PRODUCTS};

/// Rounding of the judge itself, relative to one.
const JUDGE: f64 = 1e-13;

fn random_form(rng: &mut Pcg64, centre: std::ops::Range<f64>) -> Form<Scalar> {
    let mut form = Form::constant(Scalar::new(), rng.random_range(centre));
    let size = 10.0_f64.powf(rng.random_range(-3.0..0.0));
    // Often one part alone, so that a state exists where the radius is used up.
    let parts = rng.random_range(0..6);
    for i in 0..AXES {
        if parts == i || parts == 5 {
            form.linear[i] = rng.random_range(-size..size);
        }
    }
    if parts >= 4 {
        form.quadratic = core::array::from_fn(|_| rng.random_range(-size..size) / PRODUCTS as f64);
        form.radius += rng.random_range(0.0..size);
    }
    form
}

fn at(form: &Form<Scalar>, e: &[f64; AXES]) -> f64 {
    let linear: f64 = (0..AXES).map(|i| form.linear[i] * e[i]).sum();
    let products = PAIRS.iter().zip(form.quadratic);
    form.centre + linear + products.map(|((i, j), q)| q * e[*i] * e[*j]).sum::<f64>()
}

/// Corners of the box with the radius taken to either side, and states inside.
fn values(rng: &mut Pcg64, form: &Form<Scalar>) -> Vec<([f64; AXES], f64)> {
    (0..64)
        .map(|sample| {
            let side = |k: u32| if sample >> k & 1 == 1 { 1.0 } else { -1.0 };
            let e =
                core::array::from_fn(
                    |i| {
                        if sample < 32 { side(i as u32) } else { rng.random_range(-1.0..=1.0) }
                    },
                );
            (e, at(form, &e) + form.radius * side(4))
        })
        .collect()
}

/// Applies one function to many forms; the radius must hold always and be used to 0.6 at least somewhere.
fn check(
    centre: std::ops::Range<f64>,
    apply: impl Fn(&Form<Scalar>) -> Option<Form<Scalar>>,
    exact: impl Fn(f64) -> f64,
) {
    let mut rng = Pcg64::seed_from_u64(3);
    let mut used = 0.0_f64;
    for _ in 0..20_000 {
        let form = random_form(&mut rng, centre.clone());
        let Some(result) = apply(&form) else { continue };
        for (e, x) in values(&mut rng, &form) {
            let off = (exact(x) - at(&result, &e)).abs();
            assert!(
                off <= result.radius + JUDGE * (1.0 + x.abs()),
                "off by {off:e}, radius {:e}",
                result.radius
            );
            used = used.max(off / (result.radius + JUDGE * (1.0 + x.abs())));
        }
    }
    assert!(used > 0.6, "the radius is {:.1} times too large", 1.0 / used);
}

#[test]
fn sine_and_cosine_hold() {
    let simd = Scalar::new();
    check(-20.0..20.0, |form| Some(form.sin_cos(simd).0), f64::sin);
    check(-20.0..20.0, |form| Some(form.sin_cos(simd).1), f64::cos);
}

#[test]
fn softplus_and_its_slope_hold() {
    let simd = Scalar::new();
    let softplus = |y: f64| y.max(0.0) + (-y.abs()).exp().ln_1p();
    check(-5.0..5.0, |form| Some(form.softplus(simd).0), softplus);
    check(-5.0..5.0, |form| Some(form.softplus(simd).1), |y| 1.0 / (1.0 + (-y).exp()));
}

#[test]
fn square_roots_hold() {
    let simd = Scalar::new();
    let at_least = |form: &Form<Scalar>| {
        let least = form.centre - form.reach(simd).total;
        (least > 0.01).then_some(least)
    };
    check(0.3..4.0, |form| Some(form.square_roots(simd, at_least(form)?).0), f64::sqrt);
    check(0.3..4.0, |form| Some(form.square_roots(simd, at_least(form)?).1), |s| 1.0 / s.sqrt());
}

#[test]
fn products_and_sums_hold() {
    let simd = Scalar::new();
    let mut rng = Pcg64::seed_from_u64(4);
    let mut used = 0.0_f64;
    for _ in 0..20_000 {
        let (a, b) = (random_form(&mut rng, -2.0..2.0), random_form(&mut rng, -2.0..2.0));
        let factor = rng.random_range(-3.0..3.0);
        let (product, sum) = (a.times(simd, &b), a.scaled_plus(simd, factor, &b));
        for (e, x) in values(&mut rng, &a) {
            for side in [-1.0, 1.0] {
                let y = at(&b, &e) + side * b.radius;
                let off = (x * y - at(&product, &e)).abs();
                assert!(off <= product.radius + JUDGE, "product off by {off:e}, radius {:e}", product.radius);
                used = used.max(off / (product.radius + JUDGE));
                let off = (factor * x + y - at(&sum, &e)).abs();
                assert!(off <= sum.radius + JUDGE, "sum off by {off:e}, radius {:e}", sum.radius);
            }
        }
    }
    assert!(used > 0.6, "the radius is {:.1} times too large", 1.0 / used);
}

#[test]
fn the_sine_itself_is_exact_to_2_to_the_minus_48() {
    let simd = Scalar::new();
    let limit = 0.5_f64.powi(48);
    for k in -200_000..200_000_i32 {
        let x = f64::from(k) * if k % 2 == 0 { 1.1e-4 } else { 4_987.3 };
        let (sin, cos) = crate::affine::elementary::sin_cos(simd, x);
        assert!((sin - x.sin()).abs() < limit && (cos - x.cos()).abs() < limit, "at {x}");
    }
}
