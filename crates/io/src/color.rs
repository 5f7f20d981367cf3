//! Colors that distinguish scans.

/// Red, green and blue of color `k` of a sequence of colors that are easy to distinguish.
///
/// Hue, saturation (0.4 to 1) and value (0.5 to 1) advance by steps of `1/p^3`, `1/p` and `1/p^2` of
/// their ranges, and wrap around at the end. With `p^4 = p + 1`, the golden ratio of three dimensions,
/// the first `n` colors are spread evenly for every `n` (Roberts 2018, sequence R3). No color is pale or
/// dark.
///
/// # Example
/// ```
/// use gmpcr_io::distinct_color;
///
/// assert_eq!(distinct_color(0), [242, 73, 73]);
/// assert_ne!(distinct_color(1), distinct_color(2));
/// ```
pub fn distinct_color(k: usize) -> [u8; 3] {
    let advanced = |start: f64, step: f64| (start + k as f64 * step).fract();
    let hue = advanced(0.0, HUE_STEP);
    let saturation = 0.4 + 0.6 * advanced(0.5, SATURATION_STEP);
    let value = 0.5 + 0.5 * advanced(0.9, VALUE_STEP);
    // Each channel is a trapezoid over the hue.
    [5.0, 3.0, 1.0].map(|offset| {
        let place = (offset + 6.0 * hue) % 6.0;
        let darkening = place.min(4.0 - place).clamp(0.0, 1.0);
        (255.0 * value * (1.0 - saturation * darkening)).round() as u8
    })
}

const SATURATION_STEP: f64 = 0.819_172_513_396_164_4; // 1/p
const VALUE_STEP: f64 = 0.671_043_606_703_789_2; // 1/p^2
const HUE_STEP: f64 = 0.549_700_477_901_970_2; // 1/p^3

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE L*a*b*, in which a distance of 2 can just be noticed.
    fn lab(color: [u8; 3]) -> [f64; 3] {
        let [r, g, b] = color.map(|channel| match f64::from(channel) / 255.0 {
            dark if dark <= 0.04045 => dark / 12.92,
            bright => ((bright + 0.055) / 1.055).powf(2.4),
        });
        let [x, y, z] = [
            (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505,
            0.2126 * r + 0.7152 * g + 0.0722 * b,
            (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089,
        ]
        .map(|part| match part {
            dark if dark <= 0.008856 => 7.787 * dark + 16.0 / 116.0,
            bright => bright.cbrt(),
        });
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    #[test]
    fn the_first_hundred_colors_differ_clearly() {
        for (num_colors, least) in [(12, 20.0), (30, 16.0), (100, 9.0)] {
            let colors: Vec<_> = (0..num_colors).map(|k| lab(distinct_color(k))).collect();
            for (k, a) in colors.iter().enumerate() {
                for (j, b) in colors[..k].iter().enumerate() {
                    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
                    let distance = squares.sum::<f64>().sqrt();
                    assert!(distance >= least, "{j} and {k}: {distance}");
                }
            }
        }
    }

    #[test]
    fn no_color_is_pale_or_dark() {
        for k in (0..1000).chain([usize::MAX]) {
            let color = distinct_color(k).map(f64::from);
            let most = color.iter().copied().fold(0.0, f64::max);
            let least = color.iter().copied().fold(255.0, f64::min);
            assert!(most >= 127.0 && least <= 0.61 * most, "{color:?}");
        }
    }
}
