use super::*;

/// AS 241 is accurate to about one part in 10^16; rounding of the operations adds to that.
fn close(value: f64, expected: f64) -> bool {
    (value - expected).abs() <= 1e-15 * expected.abs()
}

#[test]
fn whole_numbers_of_a_uniform_distribution_are_equally_likely() {
    let die = Distribution::Uniform { min: 1.0, max: 6.0 };
    let rolls: Vec<f64> = (0..12).map(|place| die.quantile_of((f64::from(place) + 0.5) / 12.0, true)).collect();
    assert_eq!(rolls, [1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 5.0, 5.0, 6.0, 6.0]);
    let normal = Distribution::Normal { mean: 3.0, deviation: 1.0 };
    // The share 84 % lies below 3.99.
    assert_eq!((normal.quantile_of(0.84, true), normal.quantile_of(0.5, true)), (4.0, 3.0));
}

#[test]
fn whole_numbers_stay_within_the_bounds_of_their_distribution() {
    let normal = Along::Normal { mean: 1.4, deviation: 0.5, min: Some(0.6), max: Some(2.4) };
    let triangular = Along::Triangular { min: 0.9, mode: 1.0, max: 2.9 };
    for along in [normal, triangular] {
        let of = Distribution::new(&along).unwrap();
        let ends = [1e-9, 1.0 - 1e-9].map(|probability| of.quantile_of(probability, true));
        // 2.9 would be rounded to 3.
        assert_eq!(ends, [1.0, 2.0], "{along:?}");
    }
    // 0.3 would be rounded to 0, which is below the bound.
    let above = Distribution::new(&Along::Normal { mean: 0.3, deviation: 0.1, min: Some(0.2), max: None }).unwrap();
    assert_eq!(above.quantile_of(0.5, true), 1.0);
}

#[test]
fn the_normal_quantiles_are_those_in_print() {
    // The first three are the test values of AS 241; the others are in every table.
    let printed = [
        (0.25, -0.674_489_750_196_081_7),
        (0.001, -3.090_232_306_167_814),
        (1e-20, -9.262_340_089_798_408),
        (0.5, 0.0),
        (0.975, 1.959_963_984_540_054),
        (0.95, 1.644_853_626_951_472_2),
        (0.99, 2.326_347_874_040_841),
    ];
    for (probability, expected) in printed {
        let value = normal_quantile(probability);
        assert!(close(value, expected), "{probability}: {value:?}, not {expected:?}");
    }
    assert_eq!((normal_quantile(0.0), normal_quantile(1.0)), (f64::NEG_INFINITY, f64::INFINITY));
}

#[test]
fn the_quantile_is_the_inverse_of_the_share_below() {
    for number in 1..400 {
        let value = f64::from(number) * 0.02 - 4.0;
        let again = normal_quantile(normal_share(value));
        assert!((again - value).abs() < 1e-11, "{value}: {again}");
    }
}

#[test]
fn a_normal_distribution_has_its_mean_and_its_deviation() {
    let normal = Distribution::Normal { mean: 10.0, deviation: 2.0 };
    assert_eq!(normal.quantile(0.5), 10.0);
    assert!(close(normal.quantile(0.975), 10.0 + 2.0 * 1.959_963_984_540_054));
}

#[test]
fn a_cut_normal_distribution_stays_within_its_bounds_and_keeps_its_shape() {
    let cut = |min, max| Distribution::new(&Along::Normal { mean: 0.0, deviation: 1.0, min, max }).unwrap();
    // Half of what is above 0 is above the third quartile.
    assert!(close(cut(Some(0.0), None).quantile(0.5), 0.674_489_750_196_081_7));
    assert!(close(cut(None, Some(0.0)).quantile(0.5), -0.674_489_750_196_081_7));
    let both = cut(Some(-1.0), Some(2.0));
    for probability in [1e-16, 0.1, 0.5, 0.9, 1.0 - 1e-16] {
        assert!((-1.0..=2.0).contains(&both.quantile(probability)), "{probability}");
    }
    // Far from the mean, where shares from below are 1: erfc((10 + x) / sqrt 2) is half of erfc(10 / sqrt 2) at this x.
    let far = cut(Some(10.0), None);
    assert!((far.quantile(0.5) - 10.068_411_836_081_43).abs() < 1e-12, "{}", far.quantile(0.5));
    assert!((cut(None, Some(-10.0)).quantile(0.5) + far.quantile(0.5)).abs() < 1e-12);
}

#[test]
fn half_of_a_log_normal_distribution_is_below_its_median() {
    let log_normal = Distribution::LogNormal { median: 30.0, deviation: 0.2 };
    assert_eq!(log_normal.quantile(0.5), 30.0);
    // One deviation is a factor of exp(0.2).
    let above = log_normal.quantile(normal_share(1.0));
    assert!((above / 30.0 - 1.221_402_758_160_17).abs() < 1e-12, "{above}");
}

#[test]
fn a_triangular_distribution_has_its_quantiles() {
    // The area left of the mode is 1/4; a quarter of that is at half of its width.
    let triangular = Distribution::Triangular { min: 0.0, mode: 1.0, max: 4.0 };
    assert_eq!(triangular.quantile(0.25), 1.0);
    assert_eq!(triangular.quantile(0.0625), 0.5);
    // 1 - (4 - x)^2 / 12 = 11/12 at x = 3.
    assert!(close(triangular.quantile(11.0 / 12.0), 3.0));
    let left = Distribution::Triangular { min: 0.0, mode: 0.0, max: 2.0 };
    assert_eq!(left.quantile(0.75), 1.0);
    let right = Distribution::Triangular { min: 0.0, mode: 2.0, max: 2.0 };
    assert_eq!(right.quantile(0.25), 1.0);
}

#[test]
fn a_uniform_distribution_spans_its_bounds() {
    let uniform = Distribution::Uniform { min: -2.0, max: 6.0 };
    assert_eq!([0.25, 0.5, 0.75].map(|probability| uniform.quantile(probability)), [0.0, 2.0, 4.0]);
}

#[test]
fn lists_and_ranges_are_no_distributions() {
    assert_eq!(Distribution::new(&Along::Values(Vec::new())), None);
    assert_eq!(Distribution::new(&Along::Range { from: 0.0, to: 1.0, count: 2, logarithmic: false }), None);
}

#[test]
fn the_bits_are_the_same_on_every_platform() {
    let all = [
        Distribution::Normal { mean: 1.0, deviation: 0.3 },
        Distribution::new(&Along::Normal { mean: 1.0, deviation: 0.3, min: Some(0.9), max: None }).unwrap(),
        Distribution::LogNormal { median: 2.0, deviation: 0.5 },
        Distribution::Triangular { min: 0.0, mode: 1.0, max: 3.0 },
    ];
    let bits = all.map(|of| [1e-3, 0.3, 0.99].map(|probability| of.quantile(probability).to_bits()));
    // The first row is what Python's statistics.NormalDist gives, which uses AS 241 too.
    let expected = [
        [4_589_919_603_200_873_832, 4_605_765_404_827_842_511, 4_610_325_500_625_616_750],
        [4_606_286_212_579_973_704, 4_607_381_626_488_880_711, 4_610_552_775_000_146_850],
        [4_601_356_097_400_334_198, 4_609_608_570_426_220_636, 4_618_891_944_482_252_868],
        [4_588_054_334_974_619_012, 4_606_720_199_040_462_230, 4_613_386_242_186_430_843],
    ];
    assert_eq!(bits, expected);
}
