"""Commands that look at a picture or a map and drive nothing: extract, plan, fleet, roadmap."""
