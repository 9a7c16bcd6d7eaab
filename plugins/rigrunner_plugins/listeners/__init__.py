"""Listeners that notify people who are away: webhook, mail, MQTT, and what apprise reaches."""
