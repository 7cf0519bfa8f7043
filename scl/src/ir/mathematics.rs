//! EXP, LN, LOG, SIN, COS, TAN, ASIN, ACOS, ATAN and `**`, with identical bits on every computer.
//!
//! They use only operations that IEEE 754 defines exactly: + - * / and the square root of binary64, and integer
//! operations. No platform library is called, and no operations are contracted.
//!
//! Each function reduces its argument, sums a Taylor series in [twice the precision](twofold_t), and rounds the result
//! once. The error before rounding is less than 2^-60 of the result, so the rounded result differs from the exact value
//! by less than 0.51 units in the last place. Coefficients are quotients of integers.
//!
//! The functions are written once, in C: `c/mathematics.h` is included in printed programs, and the macros below read
//! it as Rust. Its expressions mean the same in both languages: no casts, no `?:`, no increments.

#![allow(clippy::all, non_camel_case_types, unused_assignments, unused_mut, unused_parens)]

type double = f64;
type i64_t = i64;
type u64_t = u64;
type size_t = usize;
type twofolds_t<'a> = &'a [twofold_t];
type digits_t<'a> = &'a [u64_t];

/// An unevaluated sum of two numbers, with about 106 bits of precision. The second is at most half a unit in the last
/// place of the first, which is therefore the rounded sum.
#[derive(Clone, Copy)]
pub(super) struct twofold_t {
    high: double,
    low: double,
}

#[derive(Clone, Copy)]
pub(super) struct turn_t {
    quadrant: u64_t,
    rest: twofold_t,
}

fn twofold_of(high: double, low: double) -> twofold_t {
    twofold_t { high, low }
}

fn turn_of(quadrant: u64_t, rest: twofold_t) -> turn_t {
    turn_t { quadrant, rest }
}

fn f64_of(bits: u64_t) -> double {
    f64::from_bits(bits)
}

fn bits_f64(x: double) -> u64_t {
    x.to_bits()
}

fn abs_f64(x: double) -> double {
    x.abs()
}

fn sqrt_f64(x: double) -> double {
    x.sqrt()
}

fn trunc_f64(x: double) -> double {
    x.trunc()
}

/// 2^k for k from -1022 to 1023.
fn power_of_2(k: i64_t) -> double {
    f64::from_bits(((k + 1023) as u64) << 52)
}

fn whole_of(x: double) -> i64_t {
    x as i64_t
}

fn real_of(x: u64_t) -> double {
    x as double
}

fn place_of(x: i64_t) -> size_t {
    x as size_t
}

/// Translates the functions of a C source, each after a heading line.
macro_rules! from_c {
    ($(#$heading:ident static $result:ident $name:ident $parameters:tt $body:tt)*) => {
        $(function! { $result $name $parameters $body })*
    };
}

macro_rules! function {
    ($result:ident $name:ident (void) { $($body:tt)* }) => {
        pub(super) fn $name() -> $result { statements! { $($body)* } }
    };
    ($result:ident $name:ident ($($ty:ident $parameter:ident),*) { $($body:tt)* }) => {
        pub(super) fn $name($(mut $parameter: $ty),*) -> $result { statements! { $($body)* } }
    };
}

macro_rules! statements {
    () => {};
    (return $value:expr; $($rest:tt)*) => {
        return $value;
        statements! { $($rest)* }
    };
    (if ($condition:expr) { $($then:tt)* } else { $($otherwise:tt)* } $($rest:tt)*) => {
        if $condition { statements! { $($then)* } } else { statements! { $($otherwise)* } }
        statements! { $($rest)* }
    };
    (if ($condition:expr) { $($then:tt)* } $($rest:tt)*) => {
        if $condition { statements! { $($then)* } }
        statements! { $($rest)* }
    };
    (while ($condition:expr) { $($body:tt)* } $($rest:tt)*) => {
        while $condition { statements! { $($body)* } }
        statements! { $($rest)* }
    };
    (static const $ty:ident $name:ident[$count:literal] = {$({$high:expr, $low:expr}),*}; $($rest:tt)*) => {
        let $name: &[$ty; $count] = &[$($ty { high: $high, low: $low }),*];
        statements! { $($rest)* }
    };
    (static const $ty:ident $name:ident[$count:literal] = {$($value:expr),*}; $($rest:tt)*) => {
        let $name: &[$ty; $count] = &[$($value),*];
        statements! { $($rest)* }
    };
    ($ty:ident $name:ident[$count:literal] = {$($value:expr),*}; $($rest:tt)*) => {
        let $name: &mut [$ty; $count] = &mut [$($value),*];
        statements! { $($rest)* }
    };
    ($ty:ident $($name:ident $(= $value:expr)?),*; $($rest:tt)*) => {
        $(let mut $name: $ty $(= $value)?;)*
        statements! { $($rest)* }
    };
    ($assignment:expr; $($rest:tt)*) => {
        $assignment;
        statements! { $($rest)* }
    };
}

include!("../c/mathematics.h");

#[cfg(test)]
mod tests {
    use super::{
        acos_f64 as acos, asin_f64 as asin, atan_f64 as atan, cos_f64 as cos, exp_f64 as exp, ln_f64 as ln,
        log_f64 as log, pow_f64 as pow, scaled, sin_f64 as sin, tan_f64 as tan, twofold_of,
    };
    use std::f64::consts::FRAC_PI_2;

    type Function = fn(f64) -> f64;

    /// Arguments whose exact result lies close to the midpoint of two numbers, or whose reduction needs all digits of 2
    /// / pi; the expected results are correctly rounded, by mpmath 1.3 with 1400 bits.
    #[test]
    fn results_are_the_exact_ones_rounded_once() {
        let cases: [(Function, u64, u64); 90] = [
            (exp, 0x407B_0449_26B5_FCE4, 0x66E8_C5E3_6F79_80C7),
            (exp, 0x4069_F871_372E_E764, 0x52AA_B83F_C978_A754),
            (exp, 0xC040_C6D7_12EF_D270, 0x3CE8_20B3_4781_C991),
            (exp, 0xC086_D159_21B6_75EC, 0x0000_0000_0018_1356),
            (exp, 0x3FD3_BE32_E2B5_AED8, 0x3FF5_C820_DE78_CB2E),
            (exp, 0xC086_1FD2_EB6F_3386, 0x0018_502D_6F65_84A9),
            (exp, 0x407E_9DE3_481A_6140, 0x6C1A_8A57_5C61_5DF3),
            (exp, 0x4059_2DCD_5F9D_B5F8, 0x4903_B9B4_54A6_90BC),
            (exp, 0xC086_F70D_8B2E_8DF5, 0x0000_0000_0000_3754),
            (ln, 0x3FEF_FFFF_FFFF_FFFE, 0xBCB0_0000_0000_0001),
            (ln, 0x47C9_808C_C4A3_5555, 0x4055_C703_384E_3477),
            (ln, 0x3FE2_FB5B_BA1F_067C, 0xBFE0_B649_24B2_935D),
            (ln, 0x3FF8_0D98_798E_2AE7, 0x3FDA_175A_EFEC_EA77),
            (ln, 0x6366_25C8_9C6A_AA87, 0x4078_956E_F771_0D37),
            (ln, 0x55D6_43A2_9466_C419, 0x406E_5DD2_294D_09B4),
            (ln, 0x1DAE_120F_11D2_33D1, 0xC077_BE82_6FB5_0409),
            (ln, 0x3FF0_0000_0000_0001, 0x3CAF_FFFF_FFFF_FFFF),
            (ln, 0x3FF0_0000_0000_0001, 0x3CAF_FFFF_FFFF_FFFF),
            (log, 0x3FFF_E916_0AC5_1D52, 0x3FD3_3025_11CC_0C72),
            (log, 0x3FEF_FFFF_DDDC_7F69, 0xBE5D_A709_15FE_2715),
            (log, 0x6776_DE9C_893D_4F7C, 0x4067_CCFE_BBC2_D860),
            (log, 0x3FE6_7813_B74B_F137, 0xBFC3_A806_B236_B580),
            (log, 0x3FEF_FFFF_ADBF_7078, 0xBE71_DC5F_D8E7_91DD),
            (log, 0x7105_CA67_48C1_06F6, 0x406D_8E2A_91FE_ED06),
            (log, 0x3FED_4B01_297C_5CD2, 0xBFA3_A75F_6769_196F),
            (log, 0x4237_4876_E800_0000, 0x4026_0000_0000_0000),
            (log, 0x430C_6BF5_2634_0000, 0x402E_0000_0000_0000),
            (sin, 0xC227_1680_87CF_A669, 0xBE9A_31D5_C4E1_02F5),
            (sin, 0xC17E_8A66_1519_D60C, 0x3FDC_11D0_A104_2F9D),
            (sin, 0xC021_E83D_B285_C4F2, 0xBFDD_0D5A_741E_B253),
            (sin, 0xC197_E5CF_F312_E0EC, 0xBFEF_FFBE_4811_DEE8),
            (sin, 0xC3B4_E79C_B991_0F57, 0xBFE9_EB1B_D1D7_8F87),
            (sin, 0x40AE_4922_3EB9_ADB4, 0xBFC4_3261_D388_C27D),
            (sin, 0xC157_8357_BF3D_ECC0, 0xBFE9_D675_769C_740E),
            (sin, 0x0C62_15C9_8D98_2DAB, 0x0C62_15C9_8D98_2DAB),
            (sin, 0x10E8_72E2_D1AF_016E, 0x10E8_72E2_D1AF_016E),
            (sin, 0x7506_AC5B_262C_A1FF, 0x3FF0_0000_0000_0000),
            (sin, 0x7FEF_FFFF_FFFF_FFFF, 0x3F74_52FC_98B3_4E97),
            (sin, 0x7FE0_0000_0000_0000, 0x3FE2_0524_8CBD_B760),
            (cos, 0x4274_417D_A449_689E, 0xBFEF_FFFF_FD8A_B0C7),
            (cos, 0x438C_FD87_1F13_AFC1, 0xBFE1_EFC7_8ED4_8B35),
            (cos, 0xBFEA_A03B_3D44_B6C0, 0x3FE5_8C1E_DDD6_62F9),
            (cos, 0x3EFE_64E5_66B2_C7D4, 0x3FEF_FFFF_FFC6_4327),
            (cos, 0xC1AE_70F3_BABA_5792, 0xBFBD_13F7_926F_4815),
            (cos, 0x6455_F197_7D91_82D7, 0x3FBC_687C_287D_7C7E),
            (cos, 0x4013_25BB_E032_14A6, 0x3FB3_0B56_31AF_2822),
            (cos, 0x1162_AAAC_C803_6A86, 0x3FF0_0000_0000_0000),
            (cos, 0x13A5_E302_CAED_C52A, 0x3FF0_0000_0000_0000),
            (cos, 0x7506_AC5B_262C_A1FF, 0xBC21_4AE7_2E6B_A22F),
            (cos, 0x7FEF_FFFF_FFFF_FFFF, 0xBFEF_FFE6_2ECF_AB75),
            (cos, 0x7FE0_0000_0000_0000, 0xBFEA_719F_26C2_32BF),
            (tan, 0x4133_F5DC_9F99_79BB, 0x3DA8_7F86_0DB8_25E8),
            (tan, 0xC025_FDBB_E9BB_A775, 0xC320_93C3_B4AE_BEB1),
            (tan, 0x4025_FDBB_E9BB_A775, 0x4320_93C3_B4AE_BEB1),
            (tan, 0x4025_FDBB_E9BB_A775, 0x4320_93C3_B4AE_BEB1),
            (tan, 0x4025_FDBB_E9BB_A775, 0x4320_93C3_B4AE_BEB1),
            (tan, 0x4025_FDBB_E9BB_A775, 0x4320_93C3_B4AE_BEB1),
            (tan, 0x41C4_D7F6_516A_6579, 0xC009_8B21_7E03_2977),
            (tan, 0x0E08_8A51_3C6E_C5DE, 0x0E08_8A51_3C6E_C5DE),
            (tan, 0x0F83_7834_5F4D_DAD8, 0x0F83_7834_5F4D_DAD8),
            (tan, 0x7506_AC5B_262C_A1FF, 0xC3BD_9BA9_A797_5636),
            (tan, 0x7FEF_FFFF_FFFF_FFFF, 0xBF74_530C_FE72_9484),
            (tan, 0x7FE0_0000_0000_0000, 0xBFE5_CE6B_4C0D_02A3),
            (asin, 0x3FEE_0208_C72F_940E, 0x3FF3_751A_2F16_D276),
            (asin, 0xBFEF_D85D_1744_5343, 0xBFF7_8EE4_42F3_F29F),
            (asin, 0x3FA1_3872_A660_0160, 0x3FA1_3947_8932_B1EC),
            (asin, 0x3FEF_FFFF_FFF0_E5FA, 0x3FF9_21EB_C8EA_6591),
            (asin, 0xBFEF_FFFF_FFC4_1DDC, 0xBFF9_21DC_601C_1DAB),
            (asin, 0x3FBB_13C9_4539_BFA0, 0x3FBB_20C6_CADF_FF2B),
            (asin, 0xBFEC_7197_2E88_DB00, 0xBFF1_8490_50B7_E37C),
            (asin, 0xBDF8_F0EB_ED89_01A0, 0xBDF8_F0EB_ED89_01A0),
            (asin, 0xBDEC_B121_08AC_FBB0, 0xBDEC_B121_08AC_FBB0),
            (acos, 0xBFDC_3B13_9BC9_CFFC, 0x4000_3894_5BD6_E49E),
            (acos, 0xBFE7_BD02_989A_CC64, 0x4003_40AD_37AF_04C2),
            (acos, 0x3FDB_65F8_1081_5DF4, 0x3FF2_0DF6_01EC_18E0),
            (acos, 0xBFEF_E2BE_50CA_0CF3, 0x4008_74D8_2264_017A),
            (acos, 0x3FEF_FFFF_045F_13B2, 0x3F4F_B9C1_C116_406C),
            (acos, 0xBFEF_FFFF_FFFF_FF12, 0x4009_21FB_3569_6CC3),
            (acos, 0xBFB9_5472_8AB0_4450, 0x3FFA_B7EC_86DE_D451),
            (acos, 0xBFB0_B8CC_7BE1_3124, 0x3FFA_2DB8_E8C5_2526),
            (acos, 0x3EA3_37D0_2068_CE48, 0x3FF9_21FA_BA85_AC15),
            (atan, 0xBFF2_D665_27BF_C1E8, 0xBFEB_BBBE_3902_0F7E),
            (atan, 0x3FF4_4E07_FAF9_9D48, 0x3FEC_E8D3_84D5_C7D4),
            (atan, 0x3F9E_4B7A_770F_5580, 0x3F9E_4937_855D_2740),
            (atan, 0x4014_A01A_F8B8_DA52, 0x3FF6_115C_A308_160F),
            (atan, 0xBFB2_F4CD_7D22_C200, 0xBFB2_EBF6_5990_3951),
            (atan, 0xC11C_70E5_8371_FB90, 0xBFF9_21F9_1432_5431),
            (atan, 0x4080_82FD_4F3B_2128, 0x3FF9_1A3A_CBF2_D19E),
            (atan, 0x37C2_0F34_0BE1_FC4B, 0x37C2_0F34_0BE1_FC4B),
            (atan, 0x3807_1BD7_C330_D20F, 0x3807_1BD7_C330_D20F),
        ];
        for (function, x, y) in cases {
            let (x, y) = (f64::from_bits(x), f64::from_bits(y));
            assert_eq!(function(x).to_bits(), y.to_bits(), "of {x:?}: {:?} instead of {y:?}", function(x));
        }
        let powers: [(u64, u64, u64); 20] = [
            (0x4055_7C31_47C9_8742, 0xC00C_62D4_1800_8914, 0x3E82_65FE_4E33_B92D),
            (0x42CF_B494_5EC2_E402, 0xBFE0_EDFE_7BAF_B040, 0x3E69_780C_84F2_5E0F),
            (0x25F7_BC31_9D50_722F, 0x4001_1B52_5331_83B9, 0x0869_671F_BB6B_45BB),
            (0x403A_268A_4C98_05D1, 0xC012_CA9A_1674_35D2, 0x3E8D_6C64_2289_230E),
            (0x4020_C99A_7716_BF8D, 0x4047_C000_0000_0000, 0x490B_B6C4_B802_3BFE),
            (0x401E_8A23_ADC1_4A8E, 0xC042_0000_0000_0000, 0x3955_7F33_0062_FB05),
            (0x4003_4735_B58D_1069, 0x4050_0000_0000_0000, 0x4502_7F94_07A0_09CE),
            (0x4057_A45A_0A8C_3CB3, 0x4008_3526_507D_F2D0, 0x412D_0B46_8A03_5522),
            (0x4049_F100_5BCB_2415, 0xC01B_0FB7_7BA5_81AA, 0x3D85_F4CB_31E8_457F),
            (0x3FF0_0000_0000_05BF, 0x4309_02F3_7469_CE38, 0x59D9_B559_76B6_8340),
            (0x3FF0_24D8_E44F_1D9C, 0x40F2_05BB_92D3_F1E1, 0x7B8B_5EF4_8BA9_061E),
            (0x4049_DC24_01EB_2940, 0xC020_AABE_5FB8_586B, 0x3CF7_9864_0021_459B),
            (0x4050_41EE_5011_4E34, 0xC012_850B_7C1A_B14C, 0x3E31_501D_2A07_C7DC),
            (0x4057_D6A9_569A_9703, 0xC01F_AD3F_BAEC_C360, 0x3CAE_79B1_26EF_CBAB),
            (0x4044_1ABB_773F_08FF, 0xC01E_5E16_F2AD_7234, 0x3D67_4168_1CB9_7F60),
            (0x3FF0_0000_0000_001D, 0xC379_525D_E27F_2EA2, 0x0000_0000_0000_5FFF),
            (0x470E_CFB9_3B5E_B300, 0x4012_E919_B254_14FE, 0x6199_DB51_C3C0_30D1),
            (0x15EE_E4AE_FD10_CFC2, 0xBFF5_D14B_5FD3_774D, 0x7935_3584_B52C_3CA9),
            (0x4046_3D47_1573_7BCA, 0x4015_BB3F_064E_352C, 0x41CA_D16C_8371_C2C9),
            (0x4047_18E0_2B6F_0A02, 0x400E_A05B_12FA_631C, 0x4141_FD76_02AE_C681),
        ];
        for (x, y, power) in powers {
            let [x, y, power] = [x, y, power].map(f64::from_bits);
            assert_eq!(pow(x, y).to_bits(), power.to_bits(), "{x:?} ** {y:?}: {:?} instead of {power:?}", pow(x, y));
        }
    }

    #[test]
    fn whole_results_are_exact() {
        for n in -1074..=1023 {
            assert_eq!(pow(2.0, f64::from(n)), scaled(twofold_of(1.0, 0.0), i64::from(n)), "2 ** {n}");
        }
        for n in 0..=22 {
            assert_eq!(log(pow(10.0, f64::from(n))), f64::from(n));
        }
        for n in 1..=5 {
            assert_eq!(pow(-7.0, f64::from(n)), f64::from((-7_i32).pow(n)));
        }
        assert_eq!([exp(0.0), cos(0.0), acos(1.0), ln(1.0), tan(0.0)], [1.0, 1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn what_has_no_result_is_no_number_and_signs_of_0_stay() {
        let (infinity, nan) = (f64::INFINITY, f64::NAN);
        for it in [
            ln(-1.0),
            log(-1e-300),
            sin(infinity),
            cos(-infinity),
            tan(infinity),
            asin(1.5),
            acos(-1.5),
            pow(-8.0, 0.5),
        ] {
            assert!(it.is_nan());
        }
        for function in [exp, ln, log, sin, cos, tan, asin, acos, atan] {
            assert!(function(nan).is_nan());
        }
        for function in [sin, tan, asin, atan] {
            assert_eq!(function(-0.0).to_bits(), (-0.0_f64).to_bits());
        }
        assert_eq!([exp(infinity), exp(-infinity), exp(710.0), exp(-746.0)], [infinity, 0.0, infinity, 0.0]);
        assert_eq!([ln(0.0), ln(-0.0), log(0.0), ln(infinity)], [-infinity, -infinity, -infinity, infinity]);
        assert_eq!([atan(infinity), atan(-1e300)], [FRAC_PI_2, -FRAC_PI_2]);
        assert_eq!([pow(nan, 0.0), pow(1.0, nan), pow(-1.0, infinity)], [1.0, 1.0, 1.0]);
        assert_eq!([pow(0.0, -1.0), pow(-0.0, -1.0), pow(-0.0, 2.0)], [infinity, -infinity, 0.0]);
        assert_eq!([pow(0.5, infinity), pow(0.5, -1e300), pow(-infinity, 3.0)], [0.0, infinity, -infinity]);
    }
}
