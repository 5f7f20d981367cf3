/// A parameter that is out of range: which, what it is, and what is allowed.
///
/// Every parameter struct of the gmpcr crates has a `validate` that returns the first such parameter. The
/// name is the path of the field within that struct; a struct that holds others puts its own path
/// [before](Self::within) theirs, so that a message names the path from the outermost struct.
///
/// ```
/// use gmpcr_geometry::InvalidParameter;
///
/// let neighbors = 0;
/// let checked = InvalidParameter::check(neighbors >= 1, "neighbors", neighbors as f64, "at least 1");
/// let error = checked.unwrap_err().within("posegraph");
/// assert_eq!(error.to_string(), "parameter posegraph.neighbors is 0: it must be at least 1");
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("parameter {name} is {value}: it must be {allowed}")]
#[non_exhaustive]
pub struct InvalidParameter {
    /// The parameter, as its path within the struct that was checked.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// The admissible values.
    pub allowed: &'static str,
}

impl InvalidParameter {
    /// The error of the parameter `name`, unless its value is allowed.
    ///
    /// # Errors
    /// Itself, if `is_allowed` is false.
    pub fn check(
        is_allowed: bool,
        name: &str,
        value: f64,
        allowed: &'static str,
    ) -> Result<(), Self> {
        if is_allowed {
            return Ok(());
        }
        Err(Self {
            name: name.to_owned(),
            value,
            allowed,
        })
    }

    /// The check of a length or a scale, which must be finite and positive.
    ///
    /// # Errors
    /// Itself, if the value is NaN, infinite, zero, or negative.
    pub fn check_positive(name: &str, value: f64) -> Result<(), Self> {
        let is_positive = value.is_finite() && value > 0.0;
        Self::check(is_positive, name, value, "finite and positive")
    }

    /// The same error with the path of the struct that holds the checked one before the name.
    pub fn within(self, path: &str) -> Self {
        Self {
            name: format!("{path}.{}", self.name),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_finite_positive_values_are_lengths() {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = InvalidParameter::check_positive("radius", value).unwrap_err();
            assert!(error.to_string().starts_with("parameter radius is "));
        }
        assert_eq!(
            InvalidParameter::check_positive("radius", f64::MIN_POSITIVE),
            Ok(())
        );
    }
}
