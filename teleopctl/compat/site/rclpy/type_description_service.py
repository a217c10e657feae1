"""``rclpy.type_description_service``. The parameter that switches the service off."""

__all__ = ["START_TYPE_DESCRIPTION_SERVICE_PARAM"]

START_TYPE_DESCRIPTION_SERVICE_PARAM = "start_type_description_service"
