# How much more wrong is the view for each millisecond of lag, by technique? A linear model of an experiment's runs.
#
#   laglab sweep techniques.json --out runs.csv
#   Rscript techniques.R runs.csv [model.csv [figure.pdf]]
#
# Base R alone: Debian's r-base-core.

arguments <- commandArgs(trailingOnly = TRUE)
if (length(arguments) == 0) stop("usage: Rscript techniques.R runs.csv [model.csv [figure.pdf]]")

runs <- read.csv(arguments[1], check.names = FALSE) # names are paths: players.0.lag_ms
runs <- runs[runs$status == "ok", ]

on <- function(name) runs[[paste0("players.0.", name)]] == "true"
level <- 1 + on("prediction") + on("reconciliation") + on("interpolation")
names <- c("none", "prediction", "+ reconciliation", "+ interpolation")
data <- data.frame(
  technique = factor(names[level], levels = names),
  lag_ms = runs[["players.0.lag_ms"]],
  error_m = runs[["players.0.remote_error_m.mean"]] # the other car, against where the server has it now
)

print(aggregate(error_m ~ lag_ms + technique, data, function(x) c(mean = mean(x), sd = sd(x), runs = length(x))))

# An intercept and a slope for each technique, in one model: the residual variance is shared.
model <- lm(error_m ~ 0 + technique + technique:lag_ms, data)
print(summary(model))
interval <- confint(model)
estimates <- data.frame(term = names(coef(model)), estimate = coef(model), low = interval[, 1], high = interval[, 2], row.names = NULL)

# Does the slope depend on the technique? The same model with one slope for all, against it.
print(anova(lm(error_m ~ technique + lag_ms, data), lm(error_m ~ technique * lag_ms, data)))

if (length(arguments) > 1) write.csv(format(estimates, digits = 15), arguments[2], row.names = FALSE, quote = FALSE)

if (length(arguments) > 2) {
  pdf(arguments[3], width = 7, height = 5)
  plot(error_m ~ lag_ms, data, col = as.integer(technique), pch = as.integer(technique), xlab = "one-way lag (ms)", ylab = "remote error (m)")
  for (i in seq_along(names)) abline(coef(model)[i], coef(model)[length(names) + i], col = i)
  legend("topleft", names, col = seq_along(names), pch = seq_along(names), bty = "n")
  invisible(dev.off())
}
