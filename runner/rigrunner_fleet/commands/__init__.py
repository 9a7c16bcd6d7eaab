"""The commands on many runs, with their help lines: one module each, imported on call."""

COMMANDS = {
    "Fleet": {
        "archive": "Index many run folders, search them and export their results.",
        "trend": "Make control charts of the results of many runs.",
        "capability": "Compare the results of many runs with limits.",
        "gauge-rr": "Estimate repeatability and reproducibility of a gauge.",
        "reanalyse": "Analyse many stored runs again, on all cores or a cluster.",
        "golden": "Regression-test new software against reference runs.",
    },
}
