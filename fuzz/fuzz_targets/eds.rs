//! EDS and DCF files of any bytes: no panic, what is offered is found, what is refused has a reason, and
//! objects are within their PDOs.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tertius::canopen::eds::{MAX_FINDINGS, ObjectDictionary, Severity};
use tertius::canopen::pdo::{Pdos, scale};
use tertius::dbc::text;

fuzz_target!(|data: &[u8]| {
    let text = text::from_bytes(data);
    let Ok(dictionary) = ObjectDictionary::parse(&text) else { return };
    let lines = text.split(['\n', '\r']).count();
    let findings = dictionary.findings();
    assert!(findings.len() <= MAX_FINDINGS);
    for finding in findings {
        assert!((1..=lines).contains(&finding.line) && !finding.to_string().is_empty());
    }
    for object in dictionary.objects() {
        for (sub_index, variable) in &object.variables {
            assert_eq!(dictionary.variable(object.index, *sub_index), Ok(variable));
            let _ = variable.configured().and_then(|value| value.whole(Some(127)));
        }
    }
    for (address, finding) in dictionary.refused() {
        assert_eq!(finding.severity, Severity::Error);
        assert_eq!(finding.object, Some(address));
    }
    let _ = dictionary.to_string();
    for pdo in Pdos::of(&dictionary, 127).sound {
        assert!(pdo.length <= 8);
        for object in &pdo.objects {
            assert!(usize::from(object.start) + usize::from(object.bits) <= 8 * pdo.length);
            if let Ok(scale) = scale(&dictionary, 127, object.index) {
                assert!(scale.factor > 0.0 && scale.factor.is_finite());
                let _ = object.plan(&scale);
            }
        }
    }
});
