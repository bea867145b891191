/* The script and the style of a report, which the build makes of report.js and report.css. */
#pragma once

extern const char ll_report_script[], ll_report_style[];
