//! Electronic data sheets (CiA 306): EDS files of devices, and DCF files of configured ones.
