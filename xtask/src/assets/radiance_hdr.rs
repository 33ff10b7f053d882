//! Radiance HDR (RGBE) files with run-length coded scanlines.

use glam::Vec3;

/// Encodes rows of `width` linear RGB pixels, top row first. `width` is 8 to 32 767.
pub fn encode(width: usize, pixels: &[Vec3]) -> Vec<u8> {
    let height = pixels.len() / width;
    let mut file =
        format!("#?RADIANCE\nSOFTWARE=cargo xtask assets\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n")
            .into_bytes();
    for row in pixels.chunks(width) {
        file.extend([2, 2, (width >> 8) as u8, width as u8]);
        let texels: Vec<[u8; 4]> = row.iter().map(|&pixel| rgbe(pixel)).collect();
        for channel in 0..4 {
            let bytes: Vec<u8> = texels.iter().map(|texel| texel[channel]).collect();
            run_length(&bytes, &mut file);
        }
    }
    file
}

/// Shared-exponent form of a non-negative colour; mantissas are rounded to nearest.
fn rgbe(pixel: Vec3) -> [u8; 4] {
    let brightest = pixel.max_element();
    if brightest < 1e-32 {
        return [0; 4];
    }
    // The exponent e with brightest in [2^(e-1), 2^e), from the bits of the float.
    let mut exponent = ((brightest.to_bits() >> 23) & 0xff) as i32 - 126;
    let mantissa = |value: f32, exponent: i32| (f64::from(value) * 2.0_f64.powi(8 - exponent)).round();
    if mantissa(brightest, exponent) > 255.0 {
        exponent += 1;
    }
    let [r, g, b] = pixel.to_array().map(|value| mantissa(value, exponent) as u8);
    [r, g, b, (exponent + 128) as u8]
}

/// Runs of four and more become (128 + length, value), everything else is copied after its length.
fn run_length(bytes: &[u8], file: &mut Vec<u8>) {
    const SHORTEST: usize = 4;
    let run_at = |start: usize| bytes[start..].iter().take(127).take_while(|&&b| b == bytes[start]).count();
    let mut start = 0;
    while start < bytes.len() {
        let run = run_at(start);
        if run >= SHORTEST {
            file.extend([128 + run as u8, bytes[start]]);
            start += run;
            continue;
        }
        let mut end = start + 1;
        while end < bytes.len() && end - start < 128 && run_at(end) < SHORTEST {
            end += 1;
        }
        file.push((end - start) as u8);
        file.extend(&bytes[start..end]);
        start = end;
    }
}
